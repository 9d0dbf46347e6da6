#include <dn/files/pair_clock.h>
#include <dn/geo/gps_time.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/text_table.h>
#include <dn/median.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>
#include <vector>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kFewestPairs = 20, kMostPairs = 300;
constexpr double kLargestOffsetS = 40.0, kOffsetStepS = 0.5, kLeastOffsetS = 1.0;
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

/// A change of the pairs with which their points may agree.
struct PairChange {
  double offset_i_s = 0.0, offset_j_s = 0.0, scale = 1.0;
};

/// Returns the median distance of the ground points of the pairs; nullopt if too many have no pose.
std::optional<double> MedianDistance(const std::vector<LidarPair>& pairs, const BodyPoses& poses,
                                     const Mounting& mounting, const PairChange& change) {
  std::vector<double> distances_m;
  for (const LidarPair& pair : pairs) {
    const auto i = poses.At(pair.t_i_s - change.offset_i_s);
    const auto j = poses.At(pair.t_j_s - change.offset_j_s);
    if (!i || !j) continue;
    distances_m.push_back((Georeference(*i, mounting, change.scale * pair.u_i_s) -
                           Georeference(*j, mounting, change.scale * pair.u_j_s))
                              .norm());
  }
  if (distances_m.size() < std::max(kFewestPairs, pairs.size() / 2)) return std::nullopt;
  return Median(distances_m);
}

double MedianPairRange(const std::vector<LidarPair>& pairs) {
  std::vector<double> ranges_m;
  for (const LidarPair& pair : pairs) ranges_m.push_back(pair.u_i_s.norm());
  return Median(ranges_m);
}

/// Pairs whose points do not agree as they are.
class PairComparison {
 public:
  PairComparison(const Flight& flight, std::vector<LidarPair> pairs)
      : poses_(flight), mounting_(flight.config.lidar->mounting), pairs_(std::move(pairs)) {
    if (pairs_.size() < kFewestPairs || poses_.empty()) return;
    const std::optional<double> as_is_m = Distance({});
    if (as_is_m) as_is_share_ = *as_is_m / MedianPairRange(pairs_);
    as_is_m_ = as_is_m;
  }

  /// Returns whether the points are apart by more than a boresight and a lever arm explain. scale:
  /// factor that corrects the ranges.
  bool Disagree(double scale = 1.0) const {
    return as_is_share_ >= kLeastShareOfRange * std::min(1.0, scale);
  }

  /// Returns whether the points are several times closer with a change.
  bool Explains(const PairChange& change) const {
    const std::optional<double> distance_m = Distance(change);
    return distance_m && kCloser * *distance_m <= *as_is_m_;
  }

  /// Returns the offset with the smallest distance. `change`: what an offset changes.
  template <class Change>
  double BestOffset(const Change& change) const {
    double best_m = *as_is_m_, best_s = 0.0;
    for (double offset_s = -kLargestOffsetS; offset_s <= kLargestOffsetS;
         offset_s += kOffsetStepS) {
      const std::optional<double> distance_m = Distance(change(offset_s));
      if (!distance_m || *distance_m >= best_m) continue;
      best_m = *distance_m;
      best_s = offset_s;
    }
    return best_s;
  }

 private:
  std::optional<double> Distance(const PairChange& change) const {
    return MedianDistance(pairs_, poses_, mounting_, change);
  }

  BodyPoses poses_;
  const Mounting& mounting_;
  std::vector<LidarPair> pairs_;
  std::optional<double> as_is_m_;
  double as_is_share_ = 0.0;  // of the median range
};

/// Returns the pairs of a flight if their points do not agree, or not for ranges in other units.
std::optional<PairComparison> Disagreeing(const Flight& flight, double scale) {
  if (!flight.pairs || !flight.config.lidar) return std::nullopt;
  PairComparison pairs(flight, SomePairs(flight.pairs->pairs));
  if (!pairs.Disagree(scale)) return std::nullopt;
  return pairs;
}

}  // namespace

std::string LidarClockHint(double offset_s, double declared_s, double sigma_s) {
  // Leap seconds between GPS time and UTC since 2006.
  constexpr double kLeastLeapS = 14.0, kMostLeapS = 18.0, kWholeS = 0.5;
  const double whole_s = std::round(offset_s), rounded_s = std::round(10.0 * offset_s) / 10.0;
  const bool whole = std::abs(offset_s) > kMostLeapS && std::abs(offset_s - whole_s) < sigma_s;
  const bool leap = whole_s <= -kLeastLeapS && whole_s >= -kMostLeapS &&
                    std::abs(offset_s - whole_s) < std::min(kWholeS, sigma_s);
  const double days = std::round(offset_s / kDayS);
  const bool other_day = days != 0.0 && std::abs(offset_s - days * kDayS) <= sigma_s;
  const double value_s = leap || whole ? whole_s : other_day ? days * kDayS : rounded_s;
  const char* cause = leap        ? ": are they in UTC? Set"
                      : other_day ? ": do they count from another day or week? Set"
                                  : "; set";
  return FormatDouble(std::abs(value_s)) + (value_s < 0.0 ? " s early" : " s late") + cause +
         " lidar.time_offset_s: " + FormatDouble(declared_s + value_s);
}

std::string PairClockText(const Flight& flight, double offset_s) {
  std::string text =
      "the ground points of the pairs do not agree as tagged; their time tags seem " +
      LidarClockHint(offset_s, flight.config.lidar->time_offset_s);
  if (!flight.trajectory) return text;
  const std::string size = FormatDouble(std::abs(offset_s));
  return text +
         (offset_s < 0.0
              ? "; or those of the trajectory are late: then subtract " + size + " s from its times"
              : "; or those of the trajectory are early: then add " + size + " s to its times");
}

void ExpectPairClock(const Flight& flight) {
  const std::optional<double> offset_s = FindPairClockOffset(flight);
  if (!offset_s) return;
  const std::vector<std::filesystem::path>& files = flight.pairs->files;
  throw InvalidInput(PairClockText(flight, *offset_s),
                     FileLocation{files.empty() ? "" : files.front().string(), 0, 0});
}

std::optional<double> FindPairClockOffset(const Flight& flight) {
  const std::optional<PairComparison> pairs = Disagreeing(flight, 1.0);
  if (!pairs) return std::nullopt;
  const double best_s = pairs->BestOffset([](double s) { return PairChange{s, s}; });
  if (std::abs(best_s) < kLeastOffsetS || !pairs->Explains({best_s, best_s})) return std::nullopt;
  return best_s;
}

PairMistake FindPairMistake(const Flight& flight) {
  using Kind = PairMistake::Kind;
  const std::optional<PairComparison> pairs = Disagreeing(flight, kFootM);
  if (!pairs) return {};
  for (const double scale : {kFootM, 1.0 / kFootM}) {
    if (pairs->Disagree(scale) && pairs->Explains({0.0, 0.0, scale})) return {Kind::kScale, scale};
  }
  if (!pairs->Disagree()) return {};
  const double first_s = pairs->BestOffset([](double s) { return PairChange{s, 0.0}; });
  const double second_s = pairs->BestOffset([](double s) { return PairChange{0.0, s}; });
  const bool first = pairs->Explains({first_s, 0.0}), second = pairs->Explains({0.0, second_s});
  if (first && second) return {Kind::kOneTag, first_s};  // only two opposite lines
  if (first) return {Kind::kFirstTag, first_s};
  if (second) return {Kind::kSecondTag, second_s};
  return {};
}

std::string PairMistakeText(const PairMistake& mistake) {
  const std::string points = "the ground points of the pairs do not agree; they do with ";
  switch (mistake.kind) {
    case PairMistake::Kind::kNone:
      return {};
    case PairMistake::Kind::kScale:
      return points + "laser vectors times " + FormatDouble(mistake.value) +
             ": are they in feet? Convert them to metres";
    case PairMistake::Kind::kFirstTag:
    case PairMistake::Kind::kSecondTag:
    case PairMistake::Kind::kOneTag:
      break;
  }
  const char* which = mistake.kind == PairMistake::Kind::kFirstTag    ? "t_i (the first time tag)"
                      : mistake.kind == PairMistake::Kind::kSecondTag ? "t_j (the second time tag)"
                                                                      : "one of the two time tags";
  return points + which + " taken as " + FormatDouble(std::abs(mistake.value)) +
         (mistake.value < 0.0 ? " s early" : " s late") +
         ": both tags of a pair must be of one clock; correct that column";
}

}  // namespace dn
