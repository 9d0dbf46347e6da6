#include <dn/adjustment/adjust.h>
#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/adjustment/trajectory_ends.h>
#include <dn/error.h>
#include <dn/geo/median_step.h>
#include <dn/parallel.h>
#include <dn/stopwatch.h>

#include <algorithm>
#include <cmath>

#include "beam_corrections.h"
#include "fixed_trajectory.h"
#include "gauss_helmert_assessment.h"

namespace dn {
namespace {

using Eigen::Vector3d;

// Width for the chi-distributed norm of a pair's misclosure; one good pair in ten exceeds it.
constexpr double kRobustWidth = 2.5;
constexpr std::size_t kChunk = 2048;  // pairs per task

PoseInterpolation Describe(const Flight& flight, const InterpolationDeviation& deviation) {
  PoseInterpolation figures;
  figures.median_step_s = MedianStep(flight.trajectory->points());
  if (flight.config.gh.libor_compat) {
    figures.method = "linear";
  } else {
    figures.method = "cubic (attitude: rotation vectors, position: ";
    figures.method += flight.trajectory->notes().velocity_from_file
                          ? "with the file's velocities)"
                          : "with differentiated positions)";
  }
  figures.cubic_minus_linear_max_rad = deviation.max_rad;
  if (deviation.n > 0.0) {
    figures.cubic_minus_linear_rms_rad = std::sqrt(deviation.sum2_rad2 / deviation.n);
  }
  return figures;
}

GaussHelmertPair MakePair(const Flight& flight, const LidarPair& pair, const TrajectoryEnds& ends,
                          InterpolationDeviation* deviation) {
  const double sigma_p_m = flight.config.lidar->sigma_p_m;
  GaussHelmertPair condition;
  condition.i = ends.At(pair.t_i_s, pair.u_i_s, deviation);
  condition.j = ends.At(pair.t_j_s, pair.u_j_s, deviation);
  condition.i.beam = pair.beam_i;
  condition.j.beam = pair.beam_j;
  condition.covariance_m2 =
      pair.covariance_m2.value_or(sigma_p_m * sigma_p_m * Eigen::Matrix3d::Identity());
  return condition;
}

GaussHelmertOptions MakeOptions(const FlightConfig& config, int threads) {
  GaussHelmertOptions options;
  options.libor_compat = config.gh.libor_compat;
  options.model = config.gh.exponential && !config.gh.libor_compat ? BoresightModel::kExponential
                                                                   : BoresightModel::kSmallAngle;
  if (config.lidar->robust == RobustKind::kHuber) {
    options.loss = {Loss::Type::kHuber, kRobustWidth};
  } else if (config.lidar->robust == RobustKind::kCauchy) {
    options.loss = {Loss::Type::kCauchy, kRobustWidth};
  }
  options.threads = threads;
  return options;
}

void FillFigures(GaussHelmertCalibration* calibration) {
  const GaussHelmertResult& adjustment = calibration->adjustment;
  AdjustmentFigures& figures = calibration->figures;
  figures.parameters = 3 + adjustment.laser.size();
  figures.outliers = adjustment.outliers;
  figures.correspondences = adjustment.pairs_kept;
}

/// Returns the ends of all pairs; none if libor's model is wanted, which knows no beams.
std::vector<GaussHelmertEnd*> AllEnds(const FlightConfig& config, GaussHelmertProblem* problem) {
  std::vector<GaussHelmertEnd*> ends;
  if (config.gh.libor_compat) return ends;
  for (GaussHelmertPair& pair : problem->pairs) {
    ends.push_back(&pair.i);
    ends.push_back(&pair.j);
  }
  return ends;
}

Eigen::VectorXd LaserVariance(const GaussHelmertCalibration& calibration) {
  const GaussHelmertResult& adjustment = calibration.adjustment;
  return ReliableVarianceFactor(adjustment.sigma0, adjustment.chi2, adjustment.redundancy) *
             adjustment.laser_covariance_apriori.diagonal() +
         calibration.scatter.other_variances;
}

}  // namespace

GaussHelmertProblem MakeGaussHelmertProblem(const Flight& flight, int threads,
                                            PoseInterpolation* interpolation) {
  if (!flight.trajectory || !flight.pairs || !flight.config.lidar || !flight.config.trajectory) {
    throw InvalidInput("the Gauss-Helmert adjustment needs a trajectory and point pairs");
  }
  const LidarConfig& lidar = *flight.config.lidar;
  GaussHelmertProblem problem;
  problem.lever_arm_b_m = lidar.mounting.lever_arm_b_m;
  problem.boresight_rad = lidar.mounting.boresight_rad;
  problem.boresight_sigma_rad = lidar.boresight_sigma_rad;
  problem.q_me = Eigen::Quaterniond(flight.frame.R_me()).normalized();
  const std::vector<LidarPair>& pairs = flight.pairs->pairs;
  problem.pairs.resize(pairs.size());
  const TrajectoryEnds ends(flight);
  std::vector<InterpolationDeviation> deviations(NumChunks(pairs.size(), kChunk));
  ParallelForChunks(pairs.size(), kChunk, threads,
                    [&](std::size_t chunk, std::size_t first, std::size_t past) {
                      for (std::size_t k = first; k < past; ++k) {
                        problem.pairs[k] = MakePair(flight, pairs[k], ends, &deviations[chunk]);
                      }
                    });
  if (interpolation != nullptr) {
    InterpolationDeviation deviation;
    for (const InterpolationDeviation& part : deviations) deviation += part;
    *interpolation = Describe(flight, deviation);
  }
  return problem;
}

GaussHelmertCalibration CalibrateGaussHelmert(const Flight& flight,
                                              const GaussHelmertFlightOptions& options) {
  adjustment_internal::CheckEstimate(flight.config, "the Gauss-Helmert adjustment");
  adjustment_internal::CheckTrajectory(flight);
  Stopwatch watch;
  GaussHelmertCalibration calibration;
  adjustment_internal::Announce(options, "poses of the pairs");
  calibration.problem =
      MakeGaussHelmertProblem(flight, options.threads, &calibration.interpolation);
  calibration.accuracy = ReadTrajectoryAccuracy(flight, calibration.problem);
  adjustment_internal::Announce(options, "Gauss-Helmert adjustment");
  calibration.options = MakeOptions(flight.config, options.threads);
  adjustment_internal::BeamAdjustment beams(flight, AllEnds(flight.config, &calibration.problem),
                                            "a pair");
  beams.Run(&calibration.problem.laser, [&] {
    calibration.adjustment = AdjustGaussHelmert(calibration.problem, calibration.options);
    return calibration.adjustment.laser;
  });
  adjustment_internal::ExpectConverged(calibration.adjustment.converged,
                                       calibration.adjustment.iterations,
                                       "the Gauss-Helmert adjustment", "pairs");
  calibration.solve_time_s = watch.Restart();

  adjustment_internal::Announce(options, "covariance under time-correlated errors");
  const std::vector<StripInterval> strips = FindStrips(flight);
  calibration.mean_range_m = adjustment_internal::MeanRange(calibration.problem);
  calibration.diversity =
      adjustment_internal::DescribeStrips(flight, strips, calibration.mean_range_m);
  calibration.scatter = EstimateCorrelatedErrorCovariance(
      calibration.problem, calibration.adjustment, calibration.options.model,
      adjustment_internal::MakeScatterOptions(calibration.accuracy, strips));
  adjustment_internal::FillBoresight(calibration.scatter, &calibration);
  FillFigures(&calibration);
  if (beams.any())
    calibration.beams = beams.Corrections(calibration.adjustment.laser, LaserVariance(calibration));
  adjustment_internal::Assess(flight, &calibration);
  calibration.covariance_time_s = watch.seconds();
  return calibration;
}

}  // namespace dn
