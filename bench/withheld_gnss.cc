/// withheld_gnss DATA_DIR [FLIGHT...]: leaves out windows of the GNSS data of measured flights and
/// smooths the rest with estimated noise. The trajectory is then compared with the data that were
/// left out. Its figures are in docs/validation/real-data.md.
#include <dn/adjustment/unknown_noise.h>
#include <dn/builder/gnss_factors.h>
#include <dn/diagnosis/solution.h>
#include <dn/imu/unknown_imu.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

namespace dn::bench {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

// The windows take a quarter of the time; every phase has other windows.
constexpr double kPeriods = 4.0;
constexpr int kPhases = 3;

/// Returns whether a time is inside a window.
bool IsWithheld(double since_begin_s, double length_s, int phase) {
  const double period_s = kPeriods * length_s;
  const double begin_s = period_s * (phase + 0.5) / kPhases;
  const double t_s = std::fmod(since_begin_s - begin_s + 1000.0 * period_s, period_s);
  return since_begin_s > begin_s && t_s < length_s;
}

/// A flight without the epochs in the windows. The last epochs are never withheld.
struct SplitFlight {
  Flight flight;
  std::vector<MapGnssEpoch> withheld;

  SplitFlight(const fs::path& folder, double length_s, int phase) {
    FlightNeeds needs;
    needs.imu = needs.gnss = true;
    flight = ReadFlight(folder, needs);
    flight.config.imu->grade = kUnknownGrade;
    flight.config.imu->model = UnknownImu();
    std::vector<MapGnssEpoch> kept;
    const double begin_s = flight.gnss->epochs.front().t_s, end_s = flight.gnss->epochs.back().t_s;
    for (const MapGnssEpoch& epoch : flight.gnss->epochs) {
      const bool is_out =
          epoch.t_s < end_s - length_s && IsWithheld(epoch.t_s - begin_s, length_s, phase);
      (is_out ? withheld : kept).push_back(epoch);
    }
    flight.gnss->epochs = kept;
  }
};

/// Sums over withheld positions, per axis.
struct Score {
  Vector3d error2 = Vector3d::Zero(), variance = Vector3d::Zero(), ratio = Vector3d::Zero();
  long count = 0;

  void Add(const Vector3d& error, const Vector3d& variance_m2) {
    error2 += error.cwiseAbs2();
    variance += variance_m2;
    ratio += error.cwiseAbs2().cwiseQuotient(variance_m2);
    ++count;
  }
};

/// Returns the variances of the position, east, north and up, at a time between the nodes.
Vector3d PositionVariance(const std::vector<TrajectorySigma>& sigmas, double t_s) {
  const auto after = std::ranges::lower_bound(sigmas, t_s, {}, &TrajectorySigma::t_s);
  if (after == sigmas.begin()) return after->position_enu_m.cwiseAbs2();
  const auto before = after - 1;
  if (after == sigmas.end()) return before->position_enu_m.cwiseAbs2();
  const double share = (t_s - before->t_s) / (after->t_s - before->t_s);
  return (1.0 - share) * before->position_enu_m.cwiseAbs2() +
         share * after->position_enu_m.cwiseAbs2();
}

/// Returns the variance of the time-correlated errors of positions.
Vector3d ProcessVariance(const Solution& solution, const GnssConfig& gnss) {
  Vector3d sum = Vector3d::Zero();
  for (const GnssProcess& process : gnss.processes) sum += process.sigma_enu_m.cwiseAbs2();
  const GnssCorrelation& found = solution.adjustment().gnss_correlation;
  if (sum.isZero() && found.significant()) sum = found.process.sigma_enu_m.cwiseAbs2();
  return sum;
}

void Predict(const SplitFlight& split, Score* score) {
  Flight flight = split.flight;
  AdjustOptions options;
  options.with_pairs = false;
  options.threads = 2;
  EstimateNoise(options, &flight);
  const Solution solution(flight, options);
  const std::vector<NavPoint> points =
      solution.CheckedTrajectory(DenseTrajectory(solution.network(), 0.01, options.threads));
  const std::vector<MapPose> poses = Trajectory(points).ToMapPoses(flight.frame);
  const std::vector<TrajectorySigma> sigmas = solution.CheckedSigmas();
  const Vector3d process_m2 = ProcessVariance(solution, *flight.config.gnss);
  for (const MapGnssEpoch& epoch : split.withheld) {
    if (epoch.t_s < poses.front().t_s || epoch.t_s > poses.back().t_s) continue;
    const MapPose pose = InterpolatePose(poses, epoch.t_s);
    const Vector3d antenna_m = pose.p_mb + pose.q_mb * flight.config.gnss->lever_arm_b_m;
    const Eigen::Matrix3d& R_m_enu = epoch.R_m_enu;
    const Vector3d white_m2 =
        (R_m_enu.transpose() * GnssPositionCovariance(epoch, *flight.config.gnss) * R_m_enu)
            .diagonal();
    score->Add(R_m_enu.transpose() * (antenna_m - epoch.p_m),
               PositionVariance(sigmas, epoch.t_s) + white_m2 + process_m2);
  }
}

void Print(const std::string& name, double length_s, const Score& score) {
  const auto n = static_cast<double>(score.count);
  const Vector3d rms = (score.error2 / n).cwiseSqrt(), sigma = (score.variance / n).cwiseSqrt(),
                 ratio = score.ratio / n;
  fmt::print(
      "{:<12} {:>3.0f} s {:>5} epochs, off by {:.3f} {:.3f} {:.3f} m rms, predicted {:.3f} "
      "{:.3f} {:.3f} m; error^2 / variance {:.2f} {:.2f} {:.2f}, mean {:.2f}\n",
      name, length_s, score.count, rms[0], rms[1], rms[2], sigma[0], sigma[1], sigma[2], ratio[0],
      ratio[1], ratio[2], ratio.mean());
  std::fflush(stdout);
}

void Run(const fs::path& data, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    for (const double length_s : {10.0, 30.0}) {
      Score score;
      for (int phase = 0; phase < kPhases; ++phase) {
        Predict(SplitFlight(data / name, length_s, phase), &score);
      }
      Print(name, length_s, score);
    }
  }
}

}  // namespace
}  // namespace dn::bench

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: withheld_gnss DATA_DIR [FLIGHT...]\n");
    return 2;
  }
  try {
    const std::vector<std::string> names(argv + 2, argv + argc);
    dn::bench::Run(argv[1],
                   names.empty() ? std::vector<std::string>{"thor75", "walk", "psins-car"} : names);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "withheld_gnss: error: {}\n", error.what());
    return 1;
  }
}
