#include <dn/calibration/adjust.h>
#include <dn/calibration/gauss_helmert_flight.h>
#include <dn/calibration/pose_interpolator.h>
#include <dn/error.h>
#include <dn/geo/median_step.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory_covariance.h>
#include <dn/parallel.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>

#include "gauss_helmert_assessment.h"
#include "gauss_helmert_check.h"
#include "turn_position.h"

namespace dn {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Eigen::Vector3d;

// On the chi-distributed norm of a pair's misclosure, exceeded by one good pair in ten.
constexpr double kRobustWidth = 2.5;
constexpr std::size_t kChunk = 2048;  // pairs of a task

double Since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

// Sigmas of trajectory_sigma.txt by time.
class SigmaFile {
 public:
  explicit SigmaFile(const fs::path& file) : table_(ReadTextTable(file, {10})) {
    ContinueAndCheckTimes(table_, keep_);
    for (const std::size_t i : keep_) {
      const double* row = table_.row(i);
      if (std::any_of(row + 1, row + 10, [](double sigma) { return !(sigma > 0.0); })) {
        throw InvalidInput("a standard deviation is not positive",
                           FileLocation{file.string(), table_.lines[i], 0});
      }
    }
  }

  void At(double t_s, Vector3d* sigma_ned_m, Vector3d* sigma_rph_rad) const {
    const auto after =
        std::upper_bound(keep_.begin(), keep_.end(), t_s,
                         [&](double t, std::size_t i) { return t < table_.row(i)[0]; });
    const double first_s = table_.row(keep_.front())[0], last_s = table_.row(keep_.back())[0];
    if (after == keep_.begin() || t_s > last_s) {
      throw InvalidInput("the pair epoch " + FormatDouble(t_s) +
                             " s lies outside the standard deviations of the trajectory (" +
                             FormatDouble(first_s) + " s to " + FormatDouble(last_s) +
                             " s); give those of the same run, or remove the file",
                         FileLocation{table_.file.string(), 0, 0});
    }
    const double* b = table_.row(after == keep_.end() ? keep_.back() : *after);
    const double* a = table_.row(*(after - 1));
    const double s = b[0] > a[0] ? (t_s - a[0]) / (b[0] - a[0]) : 0.0;
    const auto at = [&](int column) { return (1.0 - s) * a[column] + s * b[column]; };
    *sigma_ned_m = Vector3d(at(2), at(1), at(3));
    *sigma_rph_rad = Vector3d(at(7), at(8), at(9)) * kRadPerDeg;
  }

 private:
  TextTable table_;
  std::vector<std::size_t> keep_;
};

// How far cubic and linear interpolation of the attitude are apart.
struct Deviation {
  double max_rad = 0.0, sum2_rad2 = 0.0, n = 0.0;

  void Add(double angle_rad) {
    max_rad = std::max(max_rad, angle_rad);
    sum2_rad2 += angle_rad * angle_rad;
    n += 1.0;
  }
  void operator+=(const Deviation& other) {
    max_rad = std::max(max_rad, other.max_rad);
    sum2_rad2 += other.sum2_rad2;
    n += other.n;
  }
};

class PairPoses {
 public:
  explicit PairPoses(const Flight& flight)
      : linear_only_(flight.config.gh.libor_compat),
        poses_(flight.trajectory->InMap(flight.frame)) {}

  MapPose At(double t_s, Deviation* deviation) const {
    const MapPose linear = poses_.At(t_s, PoseInterpolator::Method::kLinear);
    const MapPose cubic = poses_.At(t_s, PoseInterpolator::Method::kCubic);
    deviation->Add(linear.q_mb.angularDistance(cubic.q_mb));
    return linear_only_ ? linear : cubic;
  }

 private:
  bool linear_only_;
  PoseInterpolator poses_;
};

PoseInterpolation Describe(const Flight& flight, const Deviation& deviation) {
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

GaussHelmertEnd MakeEnd(const Flight& flight, double t_s, const Vector3d& u_s,
                        const MapPose& pose) {
  const TrajectoryConfig& trajectory = *flight.config.trajectory;
  GaussHelmertEnd end;
  end.t_s = t_s;
  end.q_mb = pose.q_mb;
  end.p_mb = pose.p_mb;
  end.q_mn = Eigen::Quaterniond(flight.frame.R_mn(pose.p_mb)).normalized();
  end.sigma_ned_m = Vector3d(trajectory.sigma_xy_m, trajectory.sigma_xy_m, trajectory.sigma_z_m);
  end.sigma_rph_rad =
      Vector3d(trajectory.sigma_rp_rad, trajectory.sigma_rp_rad, trajectory.sigma_y_rad);
  end.u_b = flight.config.lidar->mounting.R_bs_nominal * u_s;
  return end;
}

GaussHelmertPair MakePair(const Flight& flight, const LidarPair& pair, const PairPoses& poses,
                          Deviation* deviation) {
  const double sigma_p_m = flight.config.lidar->sigma_p_m;
  GaussHelmertPair condition;
  condition.i = MakeEnd(flight, pair.t_i_s, pair.u_i_s, poses.At(pair.t_i_s, deviation));
  condition.j = MakeEnd(flight, pair.t_j_s, pair.u_j_s, poses.At(pair.t_j_s, deviation));
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

std::optional<fs::path> BesideTrajectory(const Flight& flight, const char* name) {
  const fs::path file =
      (flight.config.folder / flight.config.trajectory->file).replace_filename(name);
  std::error_code none;
  if (!fs::is_regular_file(file, none)) return std::nullopt;
  return file;
}

// Every pair lies in a strip of the covariance, or as close to one as its epochs are to each other.
bool Covers(const TrajectoryCovariance& covariance, const GaussHelmertProblem& problem) {
  double spacing_s = 0.0;
  for (std::size_t k = 1; k < covariance.t_s.size(); ++k) {
    if (covariance.strip[k] != covariance.strip[k - 1]) continue;
    spacing_s = std::max(spacing_s, covariance.t_s[k] - covariance.t_s[k - 1]);
  }
  const auto covered = [&](double t_s) {
    const auto after = std::upper_bound(covariance.t_s.begin(), covariance.t_s.end(), t_s);
    const bool near_after = after != covariance.t_s.end() && *after - t_s <= spacing_s;
    return near_after || (after != covariance.t_s.begin() && t_s - *(after - 1) <= spacing_s);
  };
  return std::all_of(problem.pairs.begin(), problem.pairs.end(), [&](const GaussHelmertPair& pair) {
    return covered(pair.i.t_s) && covered(pair.j.t_s);
  });
}

// The standard deviations and the covariance are the output of one run.
void CheckOneRun(const TrajectoryCovariance& covariance, const SigmaFile& sigma_file,
                 const fs::path& file) {
  constexpr double kTolerance = 0.01;
  for (std::size_t k = 0; k < covariance.t_s.size(); ++k) {
    Vector3d sigma_ned_m, sigma_rph_rad;
    sigma_file.At(covariance.t_s[k], &sigma_ned_m, &sigma_rph_rad);
    const auto at = static_cast<Eigen::Index>(6 * k);
    const double sigma_up_m = std::sqrt(covariance.covariance(at + 2, at + 2));
    if (std::abs(sigma_up_m - sigma_ned_m.z()) > kTolerance * sigma_ned_m.z()) {
      throw InvalidInput("it is of another run than trajectory_sigma.txt: sigma up at " +
                             FormatDouble(covariance.t_s[k]) + " s is " + FormatDouble(sigma_up_m) +
                             " m here, " + FormatDouble(sigma_ned_m.z()) +
                             " m there; remove it, or smooth the flight again",
                         FileLocation{file.string(), 0, 0});
    }
  }
}

PoseCovariance InMap(const Flight& flight, const TrajectoryCovariance& stated,
                     const fs::path& file) {
  PoseCovariance out{stated.t_s, stated.strip, stated.covariance};
  for (std::size_t k = 0; k < out.t_s.size(); ++k) {
    const NavPoint& point = flight.trajectory->PointFrom(out.t_s[k]);
    internal::TurnPosition(flight.frame.R_m_enu(flight.frame.ToMap(point.position)), k,
                           &out.covariance);
  }
  try {
    out.Validate();
  } catch (const InvalidConfig& error) {
    throw InvalidInput(std::string(error.what()) + "; smooth the flight again, or remove the file",
                       FileLocation{file.string(), 0, 0});
  }
  return out;
}

void CheckTrajectory(const Flight& flight) {
  if (!flight.trajectory || !flight.trajectory->notes().adjusted_with_lidar) return;
  throw InvalidInput(
      "the trajectory was adjusted together with lidar pairs (by `dn calibrate`), which the "
      "Gauss-Helmert adjustment would use a second time; make one without them with `dn smooth " +
          flight.config.folder.string() +
          " --out DIR` and give it with --trajectory DIR/trajectory.out",
      {(flight.config.folder / flight.config.trajectory->file).string()});
}

void CheckEstimate(const FlightConfig& config) {
  const auto is_boresight = [](const EstimateEntry& entry) { return entry.unknown == "boresight"; };
  if (std::none_of(config.estimate.begin(), config.estimate.end(), is_boresight)) {
    throw InvalidConfig(
        "the Gauss-Helmert adjustment estimates the boresight, which `estimate` does not name");
  }
}

TrajectoryScatterOptions MakeScatterOptions(const TrajectoryAccuracy& accuracy,
                                            const std::vector<StripInterval>& strips) {
  TrajectoryScatterOptions options;
  options.covariance = accuracy.covariance;
  options.sigma_ned_m = accuracy.sigma_ned_m;
  options.sigma_rph_rad = accuracy.sigma_rph_rad;
  options.of_whole_error = accuracy.of_whole_error;
  for (const StripInterval& strip : strips) options.strip_begin_s.push_back(strip.t0_s);
  std::sort(options.strip_begin_s.begin(), options.strip_begin_s.end());
  return options;
}

void FillBoresight(GaussHelmertCalibration* calibration) {
  const GaussHelmertResult& adjustment = calibration->adjustment;
  BoresightResult& boresight = calibration->boresight;
  boresight.angles_rad = adjustment.boresight_rad;
  boresight.euler_zyx_rad = RollPitchHeading(Exp(adjustment.boresight_rad));
  calibration->constant_rad2 =
      calibration->scatter.constant_share * calibration->accuracy.attitude_covariance_rad2;
  boresight.covariance_rad2 =
      ReliableCovariance(adjustment, calibration->scatter, calibration->constant_rad2);
  boresight.condition_number = adjustment.condition_number;
  boresight.sigma_apriori_rad = adjustment.covariance_apriori_rad2.diagonal().cwiseSqrt();
  boresight.sigma_scaled_rad = adjustment.covariance_scaled_rad2.diagonal().cwiseSqrt();
  AdjustmentFigures& figures = calibration->figures;
  figures.sigma0 = adjustment.sigma0;
  figures.chi2 = adjustment.chi2;
  figures.redundancy = adjustment.redundancy;
  figures.iterations = adjustment.iterations;
  figures.converged = adjustment.converged;
  figures.parameters = 3;
  figures.outliers = adjustment.outliers;
  figures.correspondences = adjustment.pairs_kept;
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
  const PairPoses poses(flight);
  std::vector<Deviation> deviations(NumChunks(pairs.size(), kChunk));
  ParallelForChunks(pairs.size(), kChunk, threads,
                    [&](std::size_t chunk, std::size_t first, std::size_t past) {
                      for (std::size_t k = first; k < past; ++k) {
                        problem.pairs[k] = MakePair(flight, pairs[k], poses, &deviations[chunk]);
                      }
                    });
  if (interpolation != nullptr) {
    Deviation deviation;
    for (const Deviation& part : deviations) deviation += part;
    *interpolation = Describe(flight, deviation);
  }
  return problem;
}

TrajectoryAccuracy ReadTrajectoryAccuracy(const Flight& flight,
                                          const GaussHelmertProblem& problem) {
  std::optional<SigmaFile> sigma_file;
  if (const auto file = BesideTrajectory(flight, "trajectory_sigma.txt")) sigma_file.emplace(*file);
  TrajectoryAccuracy accuracy;
  accuracy.source = sigma_file ? "trajectory_sigma.txt" : "the section trajectory of flight.yaml";
  accuracy.of_whole_error = sigma_file.has_value();
  if (const auto file = BesideTrajectory(flight, "trajectory_covariance.txt"); file && sigma_file) {
    const TrajectoryCovariance stated = ReadTrajectoryCovariance(*file);
    if (Covers(stated, problem)) {
      CheckOneRun(stated, *sigma_file, *file);
      accuracy.covariance = InMap(flight, stated, *file);
      accuracy.source = "trajectory_covariance.txt";
    }
  }
  Vector3d position2 = Vector3d::Zero(), attitude2 = Vector3d::Zero();
  const auto add = [&](const GaussHelmertEnd& end) {
    Vector3d sigma_ned_m = end.sigma_ned_m, sigma_rph_rad = end.sigma_rph_rad;
    if (sigma_file) sigma_file->At(end.t_s, &sigma_ned_m, &sigma_rph_rad);
    const Vector3d down_b = end.q_mb.conjugate() * (end.q_mn * Vector3d::UnitZ());
    const Eigen::Matrix3d F = BodyFromEulerRates(down_b) * sigma_rph_rad.asDiagonal();
    position2 += sigma_ned_m.cwiseAbs2();
    attitude2 += sigma_rph_rad.cwiseAbs2();
    accuracy.attitude_covariance_rad2 += F * F.transpose();
  };
  for (const GaussHelmertPair& pair : problem.pairs) {
    add(pair.i);
    add(pair.j);
  }
  const double n = 2.0 * static_cast<double>(problem.pairs.size());
  accuracy.sigma_ned_m = (position2 / n).cwiseSqrt();
  accuracy.sigma_rph_rad = (attitude2 / n).cwiseSqrt();
  accuracy.attitude_covariance_rad2 /= n;
  return accuracy;
}

GaussHelmertCalibration CalibrateGaussHelmert(const Flight& flight,
                                              const GaussHelmertFlightOptions& options) {
  const auto stage = [&](const std::string& name) {
    if (options.interrupted && options.interrupted()) throw Interrupted();
    if (options.progress) options.progress(name);
  };
  CheckEstimate(flight.config);
  CheckTrajectory(flight);
  const auto start = Clock::now();
  GaussHelmertCalibration calibration;
  stage("poses of the pairs");
  calibration.problem =
      MakeGaussHelmertProblem(flight, options.threads, &calibration.interpolation);
  calibration.accuracy = ReadTrajectoryAccuracy(flight, calibration.problem);
  stage("Gauss-Helmert adjustment");
  calibration.options = MakeOptions(flight.config, options.threads);
  calibration.adjustment = AdjustGaussHelmert(calibration.problem, calibration.options);
  if (!calibration.adjustment.converged) {
    throw NotConverged("the Gauss-Helmert adjustment did not converge in " +
                       std::to_string(calibration.adjustment.iterations) +
                       " iterations; are the pairs of this flight, and the mounting matrix right?");
  }
  calibration.solve_time_s = Since(start);

  const auto covariance_start = Clock::now();
  stage("covariance under time-correlated errors");
  const std::vector<StripInterval> strips = FindStrips(flight);
  internal::DescribeStrips(flight, strips, &calibration);
  calibration.scatter = EstimateTrajectoryScatter(calibration.problem, calibration.adjustment,
                                                  calibration.options.model,
                                                  MakeScatterOptions(calibration.accuracy, strips));
  FillBoresight(&calibration);
  internal::Assess(flight, &calibration);
  calibration.model_check = internal::CheckGaussHelmert(flight, strips, calibration);
  Assess(calibration.model_check, &calibration.boresight);
  calibration.covariance_time_s = Since(covariance_start);
  return calibration;
}

}  // namespace dn
