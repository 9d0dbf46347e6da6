#include <dn/adjustment/plane_flight.h>
#include <dn/error.h>
#include <dn/rotation.h>
#include <dn/stopwatch.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "beam_corrections.h"
#include "fixed_trajectory.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr long kMinPlanes = 10;
constexpr double kMinSpread = 0.3;
constexpr EffectId kRangeOffset = EffectId::kLidarRangeOffset;

/// Calls work(plane, state, point) for every kept point.
template <class Work>
void ForKept(const PlaneCalibration& calibration, const Work& work) {
  const auto& planes = calibration.problem.planes;
  for (std::size_t q = 0; q < planes.size(); ++q) {
    for (std::size_t k = 0; k < planes[q].points.size(); ++k) {
      if (calibration.adjustment.kept[q][k] == 0) continue;
      work(planes[q], calibration.adjustment.planes[q], planes[q].points[k]);
    }
  }
}

/// Returns the effect of the attitude errors on the points, as root mean squares.
facts::AttitudeInPairs AttitudeErrors(const PlaneCalibration& calibration) {
  facts::AttitudeInPairs fact;
  fact.of_planes = true;
  fact.sigma_rph_rad = calibration.accuracy.sigma_rph_rad *
                       std::max(1.0, calibration.scatter.trajectory.attitude_ratio);
  double change2 = 0.0, noise2 = 0.0, n = 0.0;
  const PlaneAdjustment& adjustment = calibration.adjustment;
  ForKept(calibration,
          [&](const ObservedPlane& plane, const PlaneState& state, const PlanePoint& point) {
            const PlanePointLinearisation at =
                LinearisePlanePoint(point, plane.sigma_m, calibration.problem.lever_arm_b_m,
                                    adjustment.boresight_rad, adjustment.range_offset_m, state);
            const Eigen::Matrix3d F =
                BodyFromEulerRates(point.end.down_b()) * fact.sigma_rph_rad.asDiagonal();
            change2 += (F.transpose() * at.J_phi).squaredNorm();
            noise2 += plane.sigma_m * plane.sigma_m;
            n += 1.0;
          });
  fact.change_m = std::sqrt(change2 / n);
  fact.pair_sigma_m = std::sqrt(noise2 / n);
  fact.range_m = calibration.mean_range_m;
  fact.size = adjustment_internal::ClassifyAttitudeError(fact.change_m, fact.pair_sigma_m,
                                                         fact.sigma_rph_rad);
  return fact;
}

void Assess(const Flight& flight, PlaneCalibration* calibration) {
  BoresightResult& boresight = calibration->boresight;
  AssessSeparability(&boresight);
  if (boresight.verdict == Verdict::kCalibrated) {
    AssessLargestSigma(boresight.sigma_rad(), &boresight);
  }
  adjustment_internal::AddGeometryReasons(AttitudeErrors(*calibration), calibration->diversity,
                                          &boresight);
  adjustment_internal::AddWideningReason(calibration->scatter.trajectory, calibration->accuracy,
                                         calibration->constant_rad2, &boresight);
  adjustment_internal::AddNotEstimated(
      flight.config, {"boresight", EffectName(kRangeOffset)},
      "the plane adjustment estimates the boresight, lidar_range_offset and beams only",
      &boresight);
  adjustment_internal::AddBeamsNotEstimated(flight.config, calibration->beams, &boresight);
}

void FillFigures(PlaneCalibration* calibration) {
  const PlaneAdjustment& adjustment = calibration->adjustment;
  AdjustmentFigures& figures = calibration->figures;
  figures.parameters = adjustment.covariance_apriori.rows() + 3 * adjustment.planes_kept;
  figures.outliers = adjustment.points_left_out;
  figures.correspondences = adjustment.points_kept;
}

void FillUnknowns(PlaneCalibration* calibration) {
  const PlaneAdjustment& adjustment = calibration->adjustment;
  if (!calibration->problem.with_range_offset) return;
  const double factor =
      ReliableVarianceFactor(adjustment.sigma0, adjustment.chi2, adjustment.redundancy);
  const double variance_m2 =
      factor * adjustment.covariance_apriori(3, 3) + calibration->scatter.range_offset_m2;
  calibration->unknowns.push_back(
      {EffectName(kRangeOffset), "m", {adjustment.range_offset_m}, {std::sqrt(variance_m2)}});
}

std::vector<GaussHelmertEnd*> AllEnds(PlaneProblem* problem) {
  std::vector<GaussHelmertEnd*> ends;
  for (ObservedPlane& plane : problem->planes) {
    for (PlanePoint& point : plane.points) ends.push_back(&point.end);
  }
  return ends;
}

Eigen::VectorXd LaserVariance(const PlaneCalibration& calibration) {
  const PlaneAdjustment& adjustment = calibration.adjustment;
  const Eigen::Index beams = adjustment.laser.size();
  return ReliableVarianceFactor(adjustment.sigma0, adjustment.chi2, adjustment.redundancy) *
             adjustment.covariance_apriori.diagonal().tail(beams) +
         calibration.scatter.trajectory.other_variances.tail(beams);
}

std::vector<const GaussHelmertEnd*> KeptEnds(const PlaneCalibration& calibration) {
  std::vector<const GaussHelmertEnd*> ends;
  ForKept(calibration, [&](const ObservedPlane&, const PlaneState&, const PlanePoint& point) {
    ends.push_back(&point.end);
  });
  return ends;
}

double MeanRange(const std::vector<const GaussHelmertEnd*>& ends) {
  double sum_m = 0.0;
  for (const GaussHelmertEnd* end : ends) sum_m += end->u_b.norm();
  return sum_m / static_cast<double>(ends.size());
}

}  // namespace

PlaneProblem MakePlaneProblem(const Flight& flight, std::vector<ObservedPlane> planes) {
  adjustment_internal::CheckEstimate(flight.config, "the plane adjustment");
  const LidarConfig& lidar = *flight.config.lidar;
  PlaneProblem problem;
  problem.lever_arm_b_m = lidar.mounting.lever_arm_b_m;
  problem.boresight_rad = lidar.mounting.boresight_rad;
  problem.boresight_sigma_rad = lidar.boresight_sigma_rad;
  for (const EstimateEntry& entry : flight.config.estimate) {
    if (!IsEffect(entry.unknown, kRangeOffset)) continue;
    problem.with_range_offset = true;
    if (const auto sigma = PriorSigma(entry)) problem.range_offset_sigma_m = (*sigma)[0];
  }
  problem.planes = std::move(planes);
  return problem;
}

void ExpectEnoughPlanes(const PlaneAdjustment& adjustment, std::size_t found) {
  if (adjustment.planes_kept < kMinPlanes) {
    throw RankDeficient(fmt::format(
        "insufficient planes: {} of {} planes that strips share fit together, at least {} are "
        "needed; fly over buildings, or calibrate by point pairs (--method dn or gh)",
        adjustment.planes_kept, found, kMinPlanes));
  }
  const double weakest =
      static_cast<double>(adjustment.planes_kept) * adjustment.normals.eigenvalues[0];
  if (weakest >= kMinSpread) return;
  throw RankDeficient(fmt::format(
      "the planes are too parallel: the slopes of {} planes in their weakest direction are worth "
      "{:.3f} of a wall, and {:.1f} is needed (ten planes of 10 deg); fly over roofs of several "
      "aspects, or calibrate by point pairs (--method dn or gh)",
      adjustment.planes_kept, weakest, kMinSpread));
}

PlaneCalibration CalibratePlanes(const Flight& flight, std::vector<ObservedPlane> planes,
                                 const GaussHelmertFlightOptions& options) {
  adjustment_internal::CheckTrajectory(flight);
  Stopwatch watch;
  PlaneCalibration calibration;
  calibration.problem = MakePlaneProblem(flight, std::move(planes));
  calibration.origin = options.vectors;
  adjustment_internal::Announce(options, "plane adjustment");
  PlaneAdjustmentOptions adjust;
  adjust.threads = options.threads;
  adjustment_internal::BeamAdjustment beams(flight, AllEnds(&calibration.problem), "a point");
  beams.Run(&calibration.problem.laser, [&] {
    calibration.adjustment = AdjustPlanes(calibration.problem, adjust);
    return calibration.adjustment.laser;
  });
  ExpectEnoughPlanes(calibration.adjustment, calibration.problem.planes.size());
  adjustment_internal::ExpectConverged(calibration.adjustment.converged,
                                       calibration.adjustment.iterations, "the plane adjustment",
                                       "strips");
  calibration.solve_time_s = watch.Restart();

  adjustment_internal::Announce(options, "covariance under time-correlated errors");
  const std::vector<const GaussHelmertEnd*> ends = KeptEnds(calibration);
  const std::vector<StripInterval> strips = FindStrips(flight);
  calibration.mean_range_m = MeanRange(ends);
  calibration.diversity =
      adjustment_internal::DescribeStrips(flight, strips, calibration.mean_range_m);
  calibration.accuracy = adjustment_internal::ReadAccuracyAt(flight, ends);
  calibration.scatter = EstimateCorrelatedErrorCovariance(
      calibration.problem, calibration.adjustment,
      adjustment_internal::MakeScatterOptions(calibration.accuracy, strips));
  adjustment_internal::FillBoresight(calibration.scatter.trajectory, &calibration);
  FillFigures(&calibration);
  FillUnknowns(&calibration);
  if (beams.any())
    calibration.beams = beams.Corrections(calibration.adjustment.laser, LaserVariance(calibration));
  Assess(flight, &calibration);
  calibration.covariance_time_s = watch.seconds();
  return calibration;
}

}  // namespace dn
