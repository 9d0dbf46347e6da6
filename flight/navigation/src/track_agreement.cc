#include <dn/builder/gnss_factors.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/offset_search.h>
#include <dn/geo/point_crs.h>
#include <dn/median.h>
#include <dn/navigation/track_agreement.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr std::size_t kMostTrackEpochs = 120;
constexpr double kFewestTrackEpochs = 20.0;
// The antenna is within this distance of the body unless flight.yaml declares its lever arm.
constexpr double kUndeclaredLeverArmM = 5.0, kTrackSigmas = 4.0;
// Tracks with a wider gap between them are in different places.
constexpr double kOnePlaceM = 1000.0;
constexpr double kLeastTrackSpeedMps = 1.0;
constexpr double kTrackCloser = 5.0;
// Positions may be so many times worse than stated.
constexpr double kNoisy = 10.0;
// Search of the shift: steps of the whole range, and how the best of them are refined.
constexpr double kCoarseSteps = 8000.0, kFinestCoarseS = 0.5;
constexpr OffsetSearch kShiftSearch{.refined = 8, .refining = 8.0, .finest_s = 0.01};
// Horizontal differences count as constant if they scatter by less than this share.
constexpr double kConstantShare = 0.2;
// Heights determine a scale by their variation if it is larger, otherwise by their size.
constexpr double kVaryingHeightsM = 8.0, kScaleTolerance = 0.03;

using TrackReading = PlaceMistake;

Geodetic Exchanged(Geodetic point) {
  std::swap(point.lat_rad, point.lon_rad);
  return point;
}

Geodetic FromRadians(Geodetic point) {
  point.lat_rad *= kDegPerRad;
  point.lon_rad *= kDegPerRad;
  return point;
}

/// A track on a map that is flat and true to scale near its origin. Heights are as they were read.
struct FlatTrack {
  std::vector<double> t_s;
  std::vector<Vector3d> p_m;
};

/// Converts coordinates to the flat map.
class FlatMap {
 public:
  explicit FlatMap(const Geodetic& origin) : origin_(origin) {}

  Vector3d operator()(const Geodetic& point) const {
    constexpr double kRadiusM = 6.378137e6;
    const double turn = 2.0 * std::numbers::pi;
    const double lon_rad = std::remainder(point.lon_rad - origin_.lon_rad, turn);
    return {kRadiusM * std::cos(origin_.lat_rad) * lon_rad,
            kRadiusM * (point.lat_rad - origin_.lat_rad), point.h_m};
  }

 private:
  Geodetic origin_;
};

std::vector<Geodetic> GnssPlaces(const Flight& flight, TrackReading reading) {
  std::vector<Geodetic> places;
  for (const MapGnssEpoch& epoch : flight.gnss->epochs) {
    const Geodetic place = flight.frame.ToGeodetic(epoch.p_m);
    places.push_back(reading == TrackReading::kGnssRadians ? FromRadians(place) : place);
  }
  return places;
}

FlatTrack GnssTrack(const Flight& flight, const std::vector<Geodetic>& places, const FlatMap& map) {
  FlatTrack track;
  for (std::size_t i = 0; i < places.size(); ++i) {
    track.t_s.push_back(flight.gnss->epochs[i].t_s);
    track.p_m.push_back(map(places[i]));
  }
  return track;
}

/// Returns the track of the antenna by the trajectory.
FlatTrack AntennaTrack(const Flight& flight, TrackReading reading, const FlatMap& map) {
  const Vector3d lever_arm_b_m = flight.config.gnss->lever_arm_b_m;
  FlatTrack track;
  track.t_s.reserve(flight.trajectory->points().size());
  track.p_m.reserve(flight.trajectory->points().size());
  for (const NavPoint& point : flight.trajectory->points()) {
    Geodetic place = point.position;
    if (reading == TrackReading::kExchanged) place = Exchanged(place);
    if (reading == TrackReading::kTrajectoryRadians) place = FromRadians(place);
    const Vector3d arm_ned_m = point.q_nb * lever_arm_b_m;
    track.t_s.push_back(point.t_s);
    track.p_m.push_back(map(place) + Vector3d(arm_ned_m.y(), arm_ned_m.x(), -arm_ned_m.z()));
  }
  return track;
}

/// Returns the gap between the bounding rectangles of two tracks; 0 if they overlap.
double GapBetween(const FlatTrack& a, const FlatTrack& b) {
  const auto bounds = [](const FlatTrack& track) {
    Eigen::AlignedBox2d box;
    for (const Vector3d& p_m : track.p_m) box.extend(Vector2d(p_m.head<2>()));
    return box;
  };
  return bounds(a).exteriorDistance(bounds(b));
}

std::optional<Vector3d> PlaceAt(const FlatTrack& track, double t_s) {
  const auto after = std::upper_bound(track.t_s.begin(), track.t_s.end(), t_s);
  if (after == track.t_s.begin() || after == track.t_s.end()) return std::nullopt;
  const std::size_t k = static_cast<std::size_t>(after - track.t_s.begin());
  const double share = (t_s - track.t_s[k - 1]) / (track.t_s[k] - track.t_s[k - 1]);
  return Vector3d(track.p_m[k - 1] + share * (track.p_m[k] - track.p_m[k - 1]));
}

/// Returns moving epochs of a track, evenly chosen.
FlatTrack MovingEpochs(const FlatTrack& track) {
  FlatTrack moving;
  for (std::size_t i = 1; i + 1 < track.t_s.size(); ++i) {
    const double step_s = track.t_s[i + 1] - track.t_s[i - 1];
    const double way_m = (track.p_m[i + 1] - track.p_m[i - 1]).head<2>().norm();
    if (way_m < kLeastTrackSpeedMps * step_s) continue;
    moving.t_s.push_back(track.t_s[i]);
    moving.p_m.push_back(track.p_m[i]);
  }
  FlatTrack chosen;
  const std::size_t step = moving.t_s.size() / kMostTrackEpochs + 1;
  for (std::size_t i = 0; i < moving.t_s.size(); i += step) {
    chosen.t_s.push_back(moving.t_s[i]);
    chosen.p_m.push_back(moving.p_m[i]);
  }
  return chosen;
}

double MedianValue(const std::vector<Vector3d>& rows, int axis) {
  std::vector<double> values;
  for (const Vector3d& row : rows) values.push_back(row[axis]);
  return Median(std::move(values));
}

/// Returns the median horizontal distance of the rows from a point.
double MedianDistanceFrom(const std::vector<Vector3d>& rows, const Vector2d& centre_m) {
  std::vector<double> distances_m;
  for (const Vector3d& row : rows) distances_m.push_back((row.head<2>() - centre_m).norm());
  return Median(std::move(distances_m));
}

/// Compares one reading of the coordinates.
class TrackMatch {
 public:
  TrackMatch(const FlatTrack& gnss, FlatTrack antenna, double tolerance_m)
      : gnss_(MovingEpochs(gnss)), antenna_(std::move(antenna)), tolerance_m_(tolerance_m) {}

  /// Fills shift, differences and heights.
  void Compare(TrackComparison* result) const {
    if (gnss_.t_s.empty() || MostMeeting() < kFewestTrackEpochs) return;
    result->tolerance_m = tolerance_m_;
    if (!SettleShift(result)) return;
    result->one_motion = true;
    const std::vector<Vector3d> apart_m = Apart(result->shift_s);
    for (int axis = 0; axis < 3; ++axis) result->apart_enu_m[axis] = MedianValue(apart_m, axis);
    result->height = JudgeHeights(result->shift_s, result->apart_enu_m.z());
  }

 private:
  /// Returns the differences of the trajectory at the epochs that it covers.
  std::vector<Vector3d> Apart(double shift_s) const {
    std::vector<Vector3d> apart_m;
    for (std::size_t i = 0; i < gnss_.t_s.size(); ++i) {
      const std::optional<Vector3d> place = PlaceAt(antenna_, gnss_.t_s[i] + shift_s);
      if (place) apart_m.push_back(*place - gnss_.p_m[i]);
    }
    return apart_m;
  }

  /// Returns the number of epochs that can meet the trajectory.
  double MostMeeting() const {
    const double gnss_s = gnss_.t_s.back() - gnss_.t_s.front();
    const double antenna_s = antenna_.t_s.back() - antenna_.t_s.front();
    return static_cast<double>(gnss_.t_s.size()) * std::min(1.0, antenna_s / gnss_s);
  }

  /// Returns the number of epochs that a shift must cover.
  std::size_t Needed() const { return static_cast<std::size_t>(0.5 * MostMeeting()); }

  double Distance(double shift_s) const {
    const std::vector<Vector3d> apart_m = Apart(shift_s);
    if (apart_m.size() < Needed()) return std::numeric_limits<double>::infinity();
    return MedianDistanceFrom(apart_m, Vector2d::Zero());
  }

  bool SettleShift(TrackComparison* result) const {
    const double as_tagged_m = Distance(0.0);
    if (as_tagged_m <= tolerance_m_ || IsConstant(as_tagged_m)) return true;
    const double shift_s = BestShift();
    const double best_m = Distance(shift_s);
    if (best_m > tolerance_m_ || kTrackCloser * best_m > as_tagged_m) {
      return as_tagged_m <= kNoisy * tolerance_m_;
    }
    result->shift_s = shift_s;
    return true;
  }

  /// Returns whether the tracks as tagged are the same but for a constant difference.
  bool IsConstant(double as_tagged_m) const {
    if (!std::isfinite(as_tagged_m)) return false;
    const std::vector<Vector3d> apart_m = Apart(0.0);
    const Vector2d centre_m(MedianValue(apart_m, 0), MedianValue(apart_m, 1));
    return MedianDistanceFrom(apart_m, centre_m) <
           std::min(tolerance_m_, kConstantShare * as_tagged_m);
  }

  double BestShift() const {
    const double from_s = antenna_.t_s.front() - gnss_.t_s.back();
    const double to_s = antenna_.t_s.back() - gnss_.t_s.front();
    const double step_s = std::max(kFinestCoarseS, (to_s - from_s) / kCoarseSteps);
    return kShiftSearch
        .Best(from_s, to_s, step_s, [this](double shift_s) { return Distance(shift_s); })
        .second;
  }

  HeightMistake JudgeHeights(double shift_s, double apart_m) const {
    if (std::abs(apart_m) <= tolerance_m_) return HeightMistake::kNone;
    const double scale = HeightScale(shift_s);
    if (std::abs(kFootM * scale - 1.0) < kScaleTolerance) return HeightMistake::kTrajectoryFeet;
    if (std::abs(scale / kFootM - 1.0) < kScaleTolerance) return HeightMistake::kGnssFeet;
    return HeightMistake::kConstant;
  }

  /// Returns the scale of the heights of the trajectory relative to those of GNSS.
  double HeightScale(double shift_s) const {
    std::vector<Vector2d> heights_m;  // GNSS, trajectory
    Vector2d mean_m = Vector2d::Zero();
    for (std::size_t i = 0; i < gnss_.t_s.size(); ++i) {
      const std::optional<Vector3d> place = PlaceAt(antenna_, gnss_.t_s[i] + shift_s);
      if (!place) continue;
      heights_m.emplace_back(gnss_.p_m[i].z(), place->z());
      mean_m += heights_m.back();
    }
    const double n = static_cast<double>(heights_m.size());
    mean_m /= n;
    double variance = 0.0, covariance = 0.0;
    for (const Vector2d& pair_m : heights_m) {
      const Vector2d d_m = pair_m - mean_m;
      variance += d_m.x() * d_m.x() / n;
      covariance += d_m.x() * d_m.y() / n;
    }
    if (std::sqrt(variance) > kVaryingHeightsM) return covariance / variance;
    return mean_m.y() / mean_m.x();
  }

  FlatTrack gnss_, antenna_;
  double tolerance_m_;
};

/// Returns the mean cosine between heading and course over the moving steps of the trajectory.
double CourseAgreement(const Trajectory& trajectory, bool exchanged) {
  const std::vector<NavPoint>& points = trajectory.points();
  double sum = 0.0, n = 0.0;
  for (std::size_t i = 0, j = 0; i < points.size(); i = j) {
    while (j < points.size() && points[j].t_s - points[i].t_s < 1.0) ++j;
    if (j == points.size()) break;
    Geodetic from = points[i].position, to = points[j].position;
    if (exchanged) {
      from = Exchanged(from);
      to = Exchanged(to);
    }
    const Vector2d way_en_m = (FlatMap(from)(to) - FlatMap(from)(from)).head<2>();
    if (way_en_m.norm() < kLeastTrackSpeedMps * (points[j].t_s - points[i].t_s)) continue;
    const Vector3d nose_ned = points[i].q_nb * Vector3d::UnitX();
    sum += Vector2d(nose_ned.y(), nose_ned.x()).normalized().dot(way_en_m.normalized());
    n += 1.0;
  }
  return n > 0.0 ? sum / n : 0.0;
}

double DistanceBetween(const Flight& flight) {
  const auto& epochs = flight.gnss->epochs;
  const auto& points = flight.trajectory->points();
  return (ToEcef(flight.frame.ToGeodetic(epochs[epochs.size() / 2].p_m)) -
          ToEcef(points[points.size() / 2].position))
      .norm();
}

}  // namespace

bool TrackComparison::Agrees() const {
  return place == PlaceMistake::kNone && one_motion && shift_s == 0.0 &&
         apart_enu_m.head<2>().norm() <= tolerance_m && height == HeightMistake::kNone;
}

std::optional<TrackComparison> CompareTracks(const Flight& flight) {
  if (!flight.trajectory || !flight.gnss || flight.gnss->epochs.empty()) return std::nullopt;
  const double tolerance_m = kUndeclaredLeverArmM + kTrackSigmas * TypicalGnssSigma(flight);
  TrackComparison result;
  result.place = PlaceMistake::kElsewhere;
  result.distance_m = DistanceBetween(flight);
  for (const TrackReading reading :
       {TrackReading::kNone, TrackReading::kExchanged, TrackReading::kTrajectoryRadians,
        TrackReading::kGnssRadians}) {
    const std::vector<Geodetic> places = GnssPlaces(flight, reading);
    const FlatMap map(places[places.size() / 2]);
    FlatTrack gnss = GnssTrack(flight, places, map);
    FlatTrack antenna = AntennaTrack(flight, reading, map);
    if (GapBetween(gnss, antenna) > kOnePlaceM) continue;
    TrackComparison found = result;
    found.place = reading;
    TrackMatch(gnss, std::move(antenna), tolerance_m).Compare(&found);
    if (found.one_motion || result.place == PlaceMistake::kElsewhere) result = found;
    if (found.one_motion) break;
  }
  if (result.place == PlaceMistake::kExchanged) {
    result.course_as_read = CourseAgreement(*flight.trajectory, false);
    result.course_exchanged = CourseAgreement(*flight.trajectory, true);
  }
  return result;
}

}  // namespace dn
