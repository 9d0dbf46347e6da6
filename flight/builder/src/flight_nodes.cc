#include <dn/builder/flight_nodes.h>
#include <dn/builder/gnss_factors.h>
#include <dn/builder/node_grid.h>
#include <dn/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <string>

namespace dn {
namespace {

constexpr double kStripJoinS = 5.0;
constexpr double kStripMarginS = 0.5;
constexpr double kLowestRateHz = 1.0;
// A shorter piece of inertial data at an end of the flight does not show its heading.
constexpr double kShortestPieceS = 10.0;

std::vector<TimeInterval> PairStrips(const Flight& flight) {
  std::vector<double> t_s;
  for (const LidarPair& pair : flight.pairs->pairs) {
    t_s.push_back(pair.t_i_s);
    t_s.push_back(pair.t_j_s);
  }
  return ClusterEpochs(std::move(t_s), kStripJoinS);
}

/// Returns the angle random walk, rad/sqrt(s), including the strongest vibration within a strip.
double LargestGyroWhite(const Flight& flight, const std::vector<TimeInterval>& strips) {
  const ImuModel& model = flight.config.imu->model;
  double added = 0.0;
  for (const ImuVibration& v : model.vibration) {
    const bool in_strip = std::any_of(strips.begin(), strips.end(), [&](const TimeInterval& s) {
      return v.t0_s <= s.t1_s && v.t1_s >= s.t0_s;
    });
    if (in_strip) added = std::max(added, v.gyro_sigma_radps * std::sqrt(flight.imu->nominal_dt_s));
  }
  return std::hypot(model.gyro.white, added);
}

/// Returns the span of the inertial data without short pieces before the first and after the last
/// gaps.
TimeInterval UsefulSpan(const ImuData& imu) {
  TimeInterval span{imu.t_begin_s(), imu.t_end_s()};
  for (const ImuGap& gap : imu.gaps) {
    if (gap.t_begin_s - span.t0_s < kShortestPieceS) span.t0_s = gap.t_end_s;
  }
  for (auto gap = imu.gaps.rbegin(); gap != imu.gaps.rend(); ++gap) {
    if (span.t1_s - gap->t_end_s < kShortestPieceS) span.t1_s = gap->t_begin_s;
  }
  if (span.t1_s > span.t0_s) return span;
  return {imu.t_begin_s(), imu.t_end_s()};
}

}  // namespace

TimeInterval NetworkSpan(const Flight& flight, bool with_pairs,
                         const CalibrationState& calibration) {
  const TimeInterval imu = UsefulSpan(*flight.imu);
  TimeInterval span{1e300, -1e300};
  long inside = 0;
  for (const MapGnssEpoch& epoch : flight.gnss->epochs) {
    const double t_s = GnssEpochTime(calibration, epoch.t_s);
    if (t_s < imu.t0_s + 1e-6 || t_s > imu.t1_s - 1e-6) continue;
    span.t0_s = std::min(span.t0_s, t_s);
    span.t1_s = std::max(span.t1_s, t_s);
    ++inside;
  }
  if (inside < 3) {
    throw InvalidInput(
        "the IMU data cover " + std::to_string(inside) +
        " GNSS epochs, but at least three are needed; check the times of imu.file and gnss.file");
  }
  if (with_pairs && flight.pairs) {
    for (const LidarPair& pair : flight.pairs->pairs) {
      span.t0_s = std::min({span.t0_s, pair.t_i_s, pair.t_j_s});
      span.t1_s = std::max({span.t1_s, pair.t_i_s, pair.t_j_s});
    }
  }
  return span;
}

std::vector<double> GnssTimes(const Flight& flight, const TimeInterval& span,
                              const CalibrationState& calibration) {
  std::vector<double> times;
  for (const MapGnssEpoch& epoch : flight.gnss->epochs) {
    const double t_s = GnssEpochTime(calibration, epoch.t_s);
    if (t_s >= span.t0_s - 1e-6 && t_s <= span.t1_s + 1e-6) times.push_back(t_s);
  }
  return times;
}

double AutoNodeRateHz(const Flight& flight, NodeRateUse use) {
  // If a fraction s of the variance is shared noise that counts as independent, a sigma is too
  // small by at most s/2. From 5 Hz on it is too small by only s/20, because the trajectory
  // dominates there (measured, docs/validation/benchmarks.md).
  struct Rung {
    double rate_hz, shared;
  };
  using Ladder = std::array<Rung, 4>;
  constexpr Ladder kResult{{{kLowestRateHz, 0.02}, {2.0, 0.02}, {5.0, 0.1}, {10.0, 0.1}}};
  constexpr Ladder kDiagnosis{{{kLowestRateHz, 0.02}, {2.0, 0.6}, {5.0, 0.6}, {10.0, 0.6}}};
  const Ladder& ladder = use == NodeRateUse::kDiagnosis ? kDiagnosis : kResult;
  constexpr double kHighestRateHz = 20.0;
  constexpr double kShortestStripS = 1.0;
  // Remaining fraction of the variance of the mean of a random walk over an interval if its end is
  // known.
  constexpr double kBridged = 0.25;
  if (!flight.config.lidar || !flight.pairs || flight.pairs->pairs.empty()) return kLowestRateHz;
  const auto ends = 2.0 * static_cast<double>(flight.pairs->pairs.size());
  double strips_s = kShortestStripS;
  const std::vector<TimeInterval> strips = PairStrips(flight);
  for (const TimeInterval& strip : strips) strips_s += strip.t1_s - strip.t0_s;
  const double noise_m_per_sqrt_s =
      LargestGyroWhite(flight, strips) * MeanRange(flight.pairs->pairs);
  double sigma_p_m = flight.config.lidar->sigma_p_m;
  for (const LidarConfig& lidar : flight.config.more_scanners) {
    sigma_p_m = std::min(sigma_p_m, lidar.sigma_p_m);
  }
  const double relative = noise_m_per_sqrt_s / sigma_p_m;
  for (const auto& [rate_hz, shared] : ladder) {
    const double ends_per_interval = std::max(1.0, ends / strips_s / rate_hz);
    if (kBridged * relative * relative / rate_hz * ends_per_interval <= shared) return rate_hz;
  }
  return kHighestRateHz;
}

double NodeRateHz(const Flight& flight, bool with_pairs) {
  const double auto_hz = with_pairs ? AutoNodeRateHz(flight) : kLowestRateHz;
  return std::max(kLowestRateHz, flight.config.network.node_rate_hz.value_or(auto_hz));
}

std::vector<double> FlightNodeTimes(const Flight& flight, const TimeInterval& span, bool with_pairs,
                                    const CalibrationState& calibration,
                                    std::optional<NetworkConfig::Inertial> inertial) {
  NodeGridOptions options;
  options.rate_in_strips_hz = NodeRateHz(flight, with_pairs);
  options.max_spacing_s = 1.0 / kLowestRateHz;
  options.every_imu_epoch =
      inertial.value_or(flight.config.network.inertial) == NetworkConfig::Inertial::kRaw;
  std::vector<TimeInterval> dense{span};
  if (with_pairs) {
    dense = PairStrips(flight);
    for (TimeInterval& interval : dense) {
      interval.t0_s -= kStripMarginS;
      interval.t1_s += kStripMarginS;
    }
  }
  return NodeTimes(*flight.imu, span, GnssTimes(flight, span, calibration), dense, options);
}

}  // namespace dn
