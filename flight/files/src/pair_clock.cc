#include <dn/files/pair_clock.h>
#include <dn/geo/text_table.h>
#include <dn/median.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kFewestPairs = 20, kMostPairs = 300;
constexpr double kLargestOffsetS = 25.0, kOffsetStepS = 0.5, kLeastOffsetS = 1.0;
constexpr double kCloser = 5.0;
// A mounting that is wrong by 10 deg moves the points of opposite lines apart by this share of
// their range at most.
constexpr double kLeastShareOfRange = 0.35;
constexpr double kLeastCourseSpeedMps = 3.0;
constexpr double kLongestGnssStepS = 5.0;

/// Poses of the body over time.
class BodyPoses {
 public:
  explicit BodyPoses(const Flight& flight) : flight_(flight) {
    if (flight.trajectory) poses_ = flight.trajectory->ToMapPoses(flight.frame);
  }

  bool empty() const {
    return poses_.empty() && (!flight_.gnss || flight_.gnss->epochs.size() < 2);
  }

  std::optional<MapPose> At(double t_s) const {
    if (poses_.empty()) return Level(t_s);
    if (t_s < poses_.front().t_s || t_s > poses_.back().t_s) return std::nullopt;
    return InterpolatePose(poses_, t_s);
  }

 private:
  /// Returns a level pose between two GNSS positions; nullopt in a gap and if it is slow.
  std::optional<MapPose> Level(double t_s) const {
    const std::vector<MapGnssEpoch>& epochs = flight_.gnss->epochs;
    const auto after =
        std::upper_bound(epochs.begin(), epochs.end(), t_s,
                         [](double t, const MapGnssEpoch& epoch) { return t < epoch.t_s; });
    if (after == epochs.begin() || after == epochs.end()) return std::nullopt;
    const MapGnssEpoch &a = *(after - 1), &b = *after;
    const double step_s = b.t_s - a.t_s;
    const Vector3d v_enu = a.R_m_enu.transpose() * (b.p_m - a.p_m) / step_s;
    const double speed_mps = v_enu.head<2>().norm();
    if (step_s > kLongestGnssStepS || speed_mps < kLeastCourseSpeedMps) return std::nullopt;
    Eigen::Matrix3d R_enu_b;
    R_enu_b.col(0) << v_enu.x() / speed_mps, v_enu.y() / speed_mps, 0.0;
    R_enu_b.col(2) = -Vector3d::UnitZ();
    R_enu_b.col(1) = R_enu_b.col(2).cross(R_enu_b.col(0));
    MapPose pose;
    pose.t_s = t_s;
    pose.p_mb = a.p_m + (t_s - a.t_s) / step_s * (b.p_m - a.p_m);
    pose.q_mb = Eigen::Quaterniond(Eigen::Matrix3d(a.R_m_enu * R_enu_b));
    return pose;
  }

  const Flight& flight_;
  std::vector<MapPose> poses_;
};

/// Returns at most kMostPairs pairs of the first scanner, evenly spaced.
std::vector<LidarPair> SomePairs(std::vector<LidarPair> pairs) {
  std::erase_if(pairs, [](const LidarPair& pair) { return pair.scanner_i + pair.scanner_j > 0; });
  const std::size_t step = std::max<std::size_t>(1, pairs.size() / kMostPairs);
  std::vector<LidarPair> some;
  for (std::size_t i = 0; i < pairs.size(); i += step) some.push_back(pairs[i]);
  return some;
}

/// Returns the median distance of the ground points of the pairs; nullopt if too many have no pose.
std::optional<double> MedianDistance(const std::vector<LidarPair>& pairs, const BodyPoses& poses,
                                     const Mounting& mounting, double offset_s) {
  std::vector<double> distances_m;
  for (const LidarPair& pair : pairs) {
    const auto i = poses.At(pair.t_i_s - offset_s), j = poses.At(pair.t_j_s - offset_s);
    if (!i || !j) continue;
    distances_m.push_back(
        (Georeference(*i, mounting, pair.u_i_s) - Georeference(*j, mounting, pair.u_j_s)).norm());
  }
  if (distances_m.size() < std::max(kFewestPairs, pairs.size() / 2)) return std::nullopt;
  return Median(distances_m);
}

double MedianPairRange(const std::vector<LidarPair>& pairs) {
  std::vector<double> ranges_m;
  for (const LidarPair& pair : pairs) ranges_m.push_back(pair.u_i_s.norm());
  return Median(ranges_m);
}

}  // namespace

std::string LidarClockHint(double offset_s, double declared_s) {
  // Leap seconds between GPS time and UTC since 2006, and the accuracy of a mean over points.
  constexpr double kLeastLeapS = 14.0, kMostLeapS = 18.0, kWholeS = 0.5;
  const double whole_s = std::round(offset_s), rounded_s = std::round(10.0 * offset_s) / 10.0;
  const bool leap =
      whole_s <= -kLeastLeapS && whole_s >= -kMostLeapS && std::abs(offset_s - whole_s) < kWholeS;
  const double value_s = leap ? whole_s : rounded_s;
  return FormatDouble(std::abs(value_s)) + (value_s < 0.0 ? " s early" : " s late") +
         (leap ? ": are they in UTC? Set" : "; set") +
         " lidar.time_offset_s: " + FormatDouble(declared_s + value_s);
}

void ExpectPairClock(const Flight& flight) {
  const std::optional<double> offset_s = FindPairClockOffset(flight);
  if (!offset_s) return;
  const std::vector<std::filesystem::path>& files = flight.pairs->files;
  throw InvalidInput(
      "the ground points of the pairs do not agree as tagged; their time tags seem " +
          LidarClockHint(*offset_s, flight.config.lidar->time_offset_s),
      FileLocation{files.empty() ? "" : files.front().string(), 0, 0});
}

std::optional<double> FindPairClockOffset(const Flight& flight) {
  if (!flight.pairs || !flight.config.lidar) return std::nullopt;
  const std::vector<LidarPair> pairs = SomePairs(flight.pairs->pairs);
  const BodyPoses poses(flight);
  if (pairs.size() < kFewestPairs || poses.empty()) return std::nullopt;
  const Mounting& mounting = flight.config.lidar->mounting;
  const std::optional<double> as_tagged_m = MedianDistance(pairs, poses, mounting, 0.0);
  if (!as_tagged_m || *as_tagged_m < kLeastShareOfRange * MedianPairRange(pairs))
    return std::nullopt;
  double best_m = *as_tagged_m, best_s = 0.0;
  for (double offset_s = -kLargestOffsetS; offset_s <= kLargestOffsetS; offset_s += kOffsetStepS) {
    const std::optional<double> distance_m = MedianDistance(pairs, poses, mounting, offset_s);
    if (!distance_m || *distance_m >= best_m) continue;
    best_m = *distance_m;
    best_s = offset_s;
  }
  if (std::abs(best_s) < kLeastOffsetS || kCloser * best_m > *as_tagged_m) return std::nullopt;
  return best_s;
}

}  // namespace dn
