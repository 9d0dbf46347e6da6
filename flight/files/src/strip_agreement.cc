#include <dn/files/pair_clock.h>
#include <dn/files/strip_agreement.h>
#include <dn/geo/offset_search.h>
#include <dn/geo/point_crs.h>
#include <dn/geo/text_table.h>
#include <dn/median.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <utility>

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using DisagreementKind = StripDisagreement::Kind;

constexpr std::size_t kMostSamples = 2000, kFewestSamples = 10, kSearchSamples = 60;
// A boresight explains so many times the turn that it makes, and always this turn.
constexpr double kTurns = 3.0, kLeastTurnRad = 1.5 * std::numbers::pi / 180.0;
// Shift that a lever arm and the noise of a point explain.
constexpr double kLeverArmM = 1.0;
// No scanner looks more forward or backward on average.
const double kMostLook = std::tan(30.0 / 180.0 * std::numbers::pi);
// No mounting is wrong by more.
const double kLargestMounting = std::tan(10.0 / 180.0 * std::numbers::pi);
constexpr double kOffsetSteps = 4000.0, kCoarseOffsetS = 0.5, kOffsetCloser = 4.0;
constexpr OffsetSearch kOffsetSearch{.refined = 6, .refining = 8.0, .finest_s = 0.005};
constexpr double kLeastOffsetS = 0.05, kLeastLookOffsetS = 0.5;
constexpr double kFootTolerance = 0.05, kReliefM = 1.0, kScaleOnly = 0.3;
// A scanner that looks in a plane keeps it within this angle; another one does not show its clock.
constexpr double kPlaneRad = 0.006, kPlaneCloser = 3.0, kSearchedLookS = 30.0;
constexpr double kLeastStripSpeedMps = 3.0;

double MedianComponent(const std::vector<Vector3d>& rows, int axis) {
  std::vector<double> values;
  for (const Vector3d& row : rows) values.push_back(row[axis]);
  return Median(std::move(values));
}

class StripComparison {
 public:
  StripComparison(const std::vector<StripSample>& samples, const PoseAt& pose_at,
                  const Mounting& mounting, double largest_turn_rad)
      : pose_at_(pose_at), mounting_(mounting), largest_turn_rad_(largest_turn_rad) {
    const std::size_t step = samples.size() / kSearchSamples + 1;
    for (std::size_t k = 0; k < samples.size(); k += step) samples_.push_back(samples[k]);
  }

  std::optional<StripDisagreement> Find(double t_begin_s, double t_end_s) const {
    if (samples_.size() < kFewestSamples) return std::nullopt;
    const bool vectors = samples_.front().u_s.has_value();
    std::optional<StripDisagreement> as_tagged = At(0.0);
    if (as_tagged && as_tagged->kind == DisagreementKind::kAbove) return as_tagged;
    std::optional<StripDisagreement> clock = vectors ? ClockByPoints(as_tagged, t_begin_s, t_end_s)
                                                     : ClockByPlace(as_tagged, t_begin_s, t_end_s);
    if (clock) return clock;
    if (!vectors) {
      std::optional<StripDisagreement> by_plane = ClockByPlane(as_tagged);
      if (by_plane) return by_plane;
    }
    if (!as_tagged) return Outside(t_begin_s, t_end_s);
    if (Explained(*as_tagged)) return std::nullopt;
    return as_tagged;
  }

 private:
  /// The points relative to where the trajectory puts them, or to the body.
  struct Differences {
    std::vector<Vector3d> apart_m;  ///< along, across, up
    std::vector<Vector2d> heights_m;
    std::vector<double> ranges_m, aside_m, speeds_mps;
    std::size_t above = 0;
  };

  Differences Compare(double offset_s) const {
    Differences all;
    for (const StripSample& sample : samples_) {
      const std::optional<MapPose> pose = pose_at_(sample.t_s - offset_s);
      if (!pose) continue;
      const Vector3d below_m(pose->p_mb.x(), pose->p_mb.y(), sample.p_m.z());
      const Vector3d there_m = sample.u_s ? Georeference(*pose, mounting_, *sample.u_s) : below_m;
      const double speed_mps = pose->v_m.head<2>().norm();
      if (speed_mps < kLeastStripSpeedMps) continue;
      const Vector2d course = pose->v_m.head<2>() / speed_mps;
      const Vector3d apart_m = sample.p_m - there_m;
      all.apart_m.emplace_back(course.dot(apart_m.head<2>()),
                               course.y() * apart_m.x() - course.x() * apart_m.y(), apart_m.z());
      all.heights_m.emplace_back(there_m.z(), sample.p_m.z());
      all.ranges_m.push_back((there_m - pose->p_mb).norm());
      all.aside_m.push_back((there_m - pose->p_mb).head<2>().norm());
      all.speeds_mps.push_back(speed_mps);
      if (sample.p_m.z() > pose->p_mb.z()) ++all.above;
    }
    return all;
  }

  bool Enough(const Differences& all) const {
    return all.apart_m.size() >= kFewestSamples && 2 * all.apart_m.size() > samples_.size();
  }

  /// Returns the shift at an offset; nullopt if too few points meet the trajectory.
  std::optional<StripDisagreement> At(double offset_s) const {
    const Differences all = Compare(offset_s);
    if (!Enough(all)) return std::nullopt;
    StripDisagreement found;
    for (int axis = 0; axis < 3; ++axis) found.apart_m[axis] = MedianComponent(all.apart_m, axis);
    const double range_m = found.range_m = Median(all.ranges_m);
    found.limit_m =
        samples_.front().u_s ? kLeverArmM + largest_turn_rad_ * range_m : kMostLook * range_m;
    if (10 * all.above > 9 * all.apart_m.size()) found.kind = DisagreementKind::kAbove;
    if (found.kind == DisagreementKind::kShift && samples_.front().u_s && InFeet(all))
      found.kind = DisagreementKind::kFeet;
    return found;
  }

  /// Returns the times if all points have tags outside of the trajectory.
  std::optional<StripDisagreement> Outside(double t_begin_s, double t_end_s) const {
    StripDisagreement found;
    found.kind = DisagreementKind::kOutside;
    found.t_begin_s = t_begin_s;
    found.t_end_s = t_end_s;
    found.t_first_s = found.t_last_s = samples_.front().t_s;
    for (const StripSample& sample : samples_) {
      if (pose_at_(sample.t_s)) return std::nullopt;
      found.t_first_s = std::min(found.t_first_s, sample.t_s);
      found.t_last_s = std::max(found.t_last_s, sample.t_s);
    }
    return found;
  }

  /// Returns whether the heights of the file are those of the trajectory in feet.
  static bool InFeet(const Differences& all) {
    Vector2d mean_m = Vector2d::Zero(), square_m2 = Vector2d::Zero();
    const double n = static_cast<double>(all.heights_m.size());
    for (const Vector2d& pair_m : all.heights_m) mean_m += pair_m / n;
    double product_m2 = 0.0;
    for (const Vector2d& pair_m : all.heights_m) {
      const Vector2d d_m = pair_m - mean_m;
      square_m2 += d_m.cwiseAbs2() / n;
      product_m2 += d_m.x() * d_m.y() / n;
    }
    if (std::sqrt(square_m2.x()) < kReliefM) return false;
    const double scale = product_m2 / square_m2.x();
    const double left_m2 = square_m2.y() - scale * product_m2;
    return std::abs(kFootM * scale - 1.0) < kFootTolerance &&
           left_m2 < kScaleOnly * kScaleOnly * square_m2.y();
  }

  /// Returns whether a boresight and a lever arm explain the shift.
  bool Explained(const StripDisagreement& found) const {
    if (found.kind != DisagreementKind::kShift) return false;
    if (!samples_.front().u_s) return std::abs(found.apart_m.x()) <= found.limit_m;
    const double aside_m = Median(Compare(0.0).aside_m);
    return found.apart_m.head<2>().norm() <= found.limit_m &&
           std::abs(found.apart_m.z()) <= kLeverArmM + largest_turn_rad_ * aside_m;
  }

  /// Returns the median distance of the points from where they should be.
  double Distance(double offset_s) const {
    const Differences all = Compare(offset_s);
    if (!Enough(all)) return std::numeric_limits<double>::infinity();
    std::vector<double> distances_m;
    for (const Vector3d& apart_m : all.apart_m) distances_m.push_back(apart_m.head<2>().norm());
    return Median(std::move(distances_m));
  }

  std::pair<double, double> BestOffset(double t_begin_s, double t_end_s) const {
    const auto [first, last] = std::minmax_element(
        samples_.begin(), samples_.end(),
        [](const StripSample& a, const StripSample& b) { return a.t_s < b.t_s; });
    const double from_s = first->t_s - t_end_s, to_s = last->t_s - t_begin_s;
    const double step_s = std::max(kCoarseOffsetS, (to_s - from_s) / kOffsetSteps);
    return kOffsetSearch.Best(from_s, to_s, step_s,
                              [this](double offset_s) { return Distance(offset_s); });
  }

  std::optional<StripDisagreement> Clock(const std::optional<StripDisagreement>& as_tagged,
                                         double offset_s, double sigma_s) const {
    StripDisagreement clock = as_tagged.value_or(StripDisagreement{});
    clock.kind = DisagreementKind::kClock;
    clock.offset_s = offset_s;
    clock.sigma_s = sigma_s;
    return clock;
  }

  /// Returns the offset that brings points with vectors to where the trajectory puts them.
  std::optional<StripDisagreement> ClockByPoints(const std::optional<StripDisagreement>& as_tagged,
                                                 double t_begin_s, double t_end_s) const {
    if (as_tagged && as_tagged->apart_m.head<2>().norm() <= as_tagged->limit_m) return std::nullopt;
    const auto [best_m, offset_s] = BestOffset(t_begin_s, t_end_s);
    const std::optional<StripDisagreement> there = At(offset_s);
    if (!there || best_m > there->limit_m || kOffsetCloser * best_m > Distance(0.0))
      return std::nullopt;
    if (std::abs(offset_s) < kLeastOffsetS) return std::nullopt;
    return Clock(as_tagged, offset_s, there->limit_m / Median(Compare(offset_s).speeds_mps));
  }

  /// Returns the offset that brings points without vectors below the trajectory.
  std::optional<StripDisagreement> ClockByPlace(const std::optional<StripDisagreement>& as_tagged,
                                                double t_begin_s, double t_end_s) const {
    if (as_tagged && Explained(*as_tagged)) return std::nullopt;
    const auto [best_m, offset_s] = BestOffset(t_begin_s, t_end_s);
    const std::optional<StripDisagreement> there = At(offset_s);
    if (!there || !std::isfinite(best_m) || !Explained(*there)) return std::nullopt;
    const double sigma_s = there->limit_m / Median(Compare(offset_s).speeds_mps);
    if (std::abs(offset_s) < sigma_s) return std::nullopt;
    const auto by_plane = PlaneOffset(offset_s - sigma_s, offset_s + sigma_s);
    if (by_plane) return Clock(as_tagged, by_plane->second, kLeastLookOffsetS);
    return Clock(as_tagged, offset_s, sigma_s);
  }

  /// Returns the scatter of the forward look of the points, rad. It is small for a scanner that
  /// looks in a plane if the time tags are right.
  double PlaneScatter(double offset_s) const {
    std::vector<double> looks_rad;
    for (const StripSample& sample : samples_) {
      const std::optional<MapPose> pose = pose_at_(sample.t_s - offset_s);
      if (!pose) continue;
      const Vector3d b = pose->q_mb.conjugate() * (sample.p_m - pose->p_mb);
      looks_rad.push_back(std::atan2(b.x(), std::hypot(b.y(), b.z())));
    }
    if (looks_rad.size() < kFewestSamples || 2 * looks_rad.size() < samples_.size())
      return std::numeric_limits<double>::infinity();
    const double middle_rad = Median(looks_rad);
    for (double& look_rad : looks_rad) look_rad = std::abs(look_rad - middle_rad);
    return Median(std::move(looks_rad));
  }

  /// Returns scatter and offset of the clearest plane between two offsets, if there is one.
  std::optional<std::pair<double, double>> PlaneOffset(double from_s, double to_s) const {
    const double step_s = std::max(0.1, (to_s - from_s) / 600.0);
    const std::pair<double, double> best = kOffsetSearch.Best(
        from_s, to_s, step_s, [this](double offset_s) { return PlaneScatter(offset_s); });
    if (best.first > kPlaneRad) return std::nullopt;
    return best;
  }

  std::optional<StripDisagreement> ClockByPlane(
      const std::optional<StripDisagreement>& as_tagged) const {
    if (!as_tagged) return std::nullopt;
    const auto best = PlaneOffset(-kSearchedLookS, kSearchedLookS);
    if (!best || std::abs(best->second) < kLeastLookOffsetS ||
        kPlaneCloser * best->first > PlaneScatter(0.0))
      return std::nullopt;
    return Clock(as_tagged, best->second, 0.1);
  }

  const PoseAt& pose_at_;
  const Mounting& mounting_;
  double largest_turn_rad_;
  std::vector<StripSample> samples_;
};

std::string Metres(double value_m) {
  char text[40];
  std::snprintf(text, sizeof text, "%.*f m", std::abs(value_m) < 10.0 ? 1 : 0, std::abs(value_m));
  return text;
}

std::string Seconds(double t_s) {
  char text[60];
  std::snprintf(text, sizeof text, "%.1f s", t_s);
  return text;
}

/// Describes a shift, for example "15 m ahead along the course, 2.1 m to the right, 50 m up".
std::string ShiftText(const Vector3d& apart_m) {
  return Metres(apart_m.x()) + (apart_m.x() < 0.0 ? " behind" : " ahead") + " along the course, " +
         Metres(apart_m.y()) + (apart_m.y() < 0.0 ? " left" : " right") + " of it and " +
         Metres(apart_m.z()) + (apart_m.z() < 0.0 ? " below" : " above");
}

}  // namespace

bool StripDisagreement::Forbids() const {
  if (kind == DisagreementKind::kFeet || kind == DisagreementKind::kAbove) return true;
  if (kind == DisagreementKind::kShift || kind == DisagreementKind::kOutside) return false;
  return range_m == 0.0 || apart_m.head<2>().norm() > kLargestMounting * range_m;
}

void StripSampler::Add(StripSample sample) {
  samples_.push_back(std::move(sample));
  if (samples_.size() < kMostSamples) return;
  for (std::size_t k = 0; 2 * k < samples_.size(); ++k) samples_[k] = samples_[2 * k];
  samples_.resize((samples_.size() + 1) / 2);
  step_ *= 2;
}

std::optional<StripDisagreement> FindStripDisagreement(const std::vector<StripSample>& samples,
                                                       const PoseAt& pose_at, double t_begin_s,
                                                       double t_end_s, const Mounting& mounting,
                                                       double largest_turn_rad) {
  return StripComparison(samples, pose_at, mounting, largest_turn_rad).Find(t_begin_s, t_end_s);
}

double LargestTurn(const Vector3d& before_rad, const Vector3d& after_rad) {
  const double turn_rad =
      std::max({(after_rad - before_rad).norm(), before_rad.norm(), after_rad.norm()});
  return std::max(kLeastTurnRad, kTurns * turn_rad);
}

std::string StripDisagreementText(const StripDisagreement& found, double declared_s) {
  const std::string shift =
      "the points lie " + ShiftText(found.apart_m) + " where the trajectory puts them";
  switch (found.kind) {
    case DisagreementKind::kShift:
      return shift + ", and a boresight moves them by " + Metres(found.limit_m) +
             " at most: are their heights and coordinates (strips_crs, frame.origin_deg_m) those "
             "of "
             "the trajectory, and are both of one adjustment?";
    case DisagreementKind::kFeet:
      return shift + ": their heights are in feet; convert the strips to metres";
    case DisagreementKind::kAbove:
      return "the points lie above the trajectory: are their heights in feet, or is their system "
             "another one (strips_crs, frame.origin_deg_m)?";
    case DisagreementKind::kOutside:
      return "the points have time tags " + Seconds(found.t_first_s) + " .. " +
             Seconds(found.t_last_s) + ", outside of the trajectory, " + Seconds(found.t_begin_s) +
             " .. " + Seconds(found.t_end_s) +
             ": do they count from another day, week or epoch? Set lidar.time_offset_s";
    case DisagreementKind::kClock:
      break;
  }
  const bool met = found.apart_m != Vector3d::Zero();
  return (met ? shift
              : std::string("the points lie along the trajectory at other times than their "
                            "tags")) +
         "; their time tags seem " + LidarClockHint(found.offset_s, declared_s, found.sigma_s);
}

}  // namespace dn
