#include "flight_plan.h"

#include <dn/geo/local_frame.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "flight_path.h"
#include "scenario_limits.h"

namespace dn {
namespace {

using Eigen::Vector2d;

// Spacing of the control points of the spline. It makes the roll into a turn take about 4 s.
constexpr double kPathStep_s = 2.0;
// Straight and level flight before and after every line. It is longer than the influence of a
// control point (6 s).
constexpr double kLeadIn_s = 9.0;
constexpr double kWarmUpLeg_s = 20.0;
constexpr double kRunOut_s = 75.0;
// Part of the path before and after the flight, for the spline and the lead.
constexpr double kPathMargin_s = 20.0;
constexpr double kIntegrationStep_s = 0.02;

/// Piece of the path. Height and speed change smoothly from the leg before to the leg after, over
/// all pieces between them. This piece covers the fractions [share0, share1] of that connection.
struct Segment {
  Waypoint start;
  double length_m = 0.0;
  double curvature_per_m = 0.0;
  double begin_m = 0.0;  // position along the whole path
  double height0_m = 0.0, height1_m = 0.0;
  double speed0_mps = 0.0, speed1_mps = 0.0;
  double share0 = 0.0, share1 = 1.0;
};

double LineHeading(const PlannedLine& line) {
  const Vector2d d = line.end_en_m - line.start_en_m;
  return std::atan2(d.x(), d.y());
}

double SmoothStep(double x) { return x * x * x * (10.0 + x * (6.0 * x - 15.0)); }

/// Returns the fraction 0..1 of the change of height and speed after `into_m` along a segment.
double ChangeDone(const Segment& s, double into_m) {
  const double x = std::clamp(into_m / s.length_m, 0.0, 1.0);
  return SmoothStep(s.share0 + (s.share1 - s.share0) * x);
}

/// Builds the whole path over ground leg by leg.
class PathBuilder {
 public:
  explicit PathBuilder(double bank_rad) : tan_bank_(std::tan(bank_rad)) {}

  /// Adds the connection to the leg's lead-in and the leg itself; returns the path lengths where
  /// the leg begins and ends.
  Vector2d AddLeg(const PlannedLine& leg) {
    const double lead_m = kLeadIn_s * leg.speed_mps;
    const double length_m = (leg.end_en_m - leg.start_en_m).norm();
    Waypoint start{leg.start_en_m, LineHeading(leg)};
    start = Advance(start, -lead_m, 0.0);
    if (segments_.empty()) {
      at_ = start;
    } else {
      Connect(start, leg);
    }
    height_m_ = leg.height_m;
    speed_mps_ = leg.speed_mps;
    const double begin_m = length_m_ + lead_m;
    Append(Begin({length_m + 2.0 * lead_m, 0.0}));
    return {begin_m, begin_m + length_m};
  }

  const std::vector<Segment>& segments() const { return segments_; }

  /// Returns the speed at a path length, m/s.
  double SpeedAt(double along_m) const {
    const Segment& s = At(along_m);
    return s.speed0_mps + (s.speed1_mps - s.speed0_mps) * ChangeDone(s, along_m - s.begin_m);
  }

  /// Returns the duration if each piece were flown at its lower speed, s.
  double LongestDuration() const {
    double sum_s = 0.0;
    for (const Segment& s : segments_) sum_s += s.length_m / std::min(s.speed0_mps, s.speed1_mps);
    return sum_s;
  }

  const Segment& At(double along_m) const {
    const auto after = std::upper_bound(
        segments_.begin(), segments_.end(), along_m,
        [](double value, const Segment& segment) { return value < segment.begin_m; });
    return after == segments_.begin() ? segments_.front() : *std::prev(after);
  }

 private:
  void Connect(const Waypoint& to, const PlannedLine& leg) {
    const double fastest_mps = std::max(speed_mps_, leg.speed_mps);
    const double radius_m = fastest_mps * fastest_mps / (kStandardGravityMps2 * tan_bank_);
    const std::vector<PathPiece> pieces = ShortestPath(at_, to, radius_m);
    const double total_m = Length(pieces);
    double done_m = 0.0;
    for (const PathPiece& piece : pieces) {
      if (piece.length_m <= 0.0) continue;
      Segment segment = Begin(piece);
      segment.share0 = done_m / total_m;
      done_m += piece.length_m;
      segment.share1 = done_m / total_m;
      segment.height1_m = leg.height_m;
      segment.speed1_mps = leg.speed_mps;
      Append(segment);
    }
  }

  Segment Begin(const PathPiece& piece) const {
    Segment segment;
    segment.start = at_;
    segment.begin_m = length_m_;
    segment.length_m = piece.length_m;
    segment.curvature_per_m = piece.curvature_per_m;
    segment.height0_m = segment.height1_m = height_m_;
    segment.speed0_mps = segment.speed1_mps = speed_mps_;
    return segment;
  }

  void Append(const Segment& segment) {
    segments_.push_back(segment);
    at_ = Advance(segment.start, segment.length_m, segment.curvature_per_m);
    length_m_ += segment.length_m;
  }

  double tan_bank_;
  std::vector<Segment> segments_;
  Waypoint at_;
  double height_m_ = 0.0;
  double speed_mps_ = 0.0;
  double length_m_ = 0.0;
};

/// Table of path lengths at equal time steps.
class Timetable {
 public:
  /// Starts with path length 0 at time 0 and ends at end_m. Outside, the motion continues at
  /// constant speed.
  Timetable(const PathBuilder& path, double end_m) {
    double along_m = 0.0;
    while (along_m < end_m) {
      along_m_.push_back(along_m);
      const double middle_m = along_m + 0.5 * kIntegrationStep_s * path.SpeedAt(along_m);
      along_m += kIntegrationStep_s * path.SpeedAt(middle_m);
    }
    along_m_.push_back(along_m);
  }

  double TimeAt(double along_m) const {
    const auto after = std::upper_bound(along_m_.begin() + 1, along_m_.end() - 1, along_m);
    const auto i = after - along_m_.begin() - 1;
    return kIntegrationStep_s *
           (static_cast<double>(i) + (along_m - along_m_[i]) / (along_m_[i + 1] - along_m_[i]));
  }

  double LengthAt(double t_s) const {
    const double steps = t_s / kIntegrationStep_s;
    const double last = static_cast<double>(along_m_.size()) - 2.0;
    const double i = std::clamp(std::floor(steps), 0.0, last);
    const auto k = static_cast<std::size_t>(i);
    return along_m_[k] + (steps - i) * (along_m_[k + 1] - along_m_[k]);
  }

 private:
  std::vector<double> along_m_;
};

/// Returns leg `index` before the first line. All these legs cross near the centre of the block;
/// successive legs are rotated by the golden angle and change height and speed.
PlannedLine WarmUpLeg(const PlanScenario& plan, int index) {
  constexpr std::array<double, 3> kHeights_m{20.0, 40.0, 0.0};
  constexpr std::array<double, 4> kSpeeds{1.0, 0.9, 1.0, 1.1};
  const double kGoldenAngle = std::numbers::pi * (3.0 - std::sqrt(5.0));
  Vector2d centre = Vector2d::Zero();
  for (const PlannedLine& line : plan.lines) centre += 0.5 * (line.start_en_m + line.end_en_m);
  centre /= static_cast<double>(plan.lines.size());
  const PlannedLine& first = plan.lines.front();
  const double heading = LineHeading(first) + kGoldenAngle * (index + 1);
  const Vector2d forward(std::sin(heading), std::cos(heading));
  PlannedLine leg;
  leg.speed_mps = first.speed_mps * kSpeeds[static_cast<std::size_t>(index) % kSpeeds.size()];
  leg.height_m = first.height_m + kHeights_m[static_cast<std::size_t>(index) % kHeights_m.size()];
  const double half_m = 0.5 * kWarmUpLeg_s * leg.speed_mps;
  leg.start_en_m = centre - half_m * forward;
  leg.end_en_m = centre + half_m * forward;
  return leg;
}

/// Returns the leg after the last strip: a turn of 120 degrees and a straight line.
PlannedLine RunOutLeg(const PlannedLine& last) {
  const double heading = LineHeading(last);
  const Vector2d forward(std::sin(heading), std::cos(heading));
  const double onward = heading + 2.0 * std::numbers::pi / 3.0;
  const Vector2d direction(std::sin(onward), std::cos(onward));
  PlannedLine leg = last;
  leg.start_en_m = last.end_en_m + 60.0 * last.speed_mps * (forward + direction);
  leg.end_en_m = leg.start_en_m + 60.0 * last.speed_mps * direction;
  return leg;
}

UniformSpline::Vector SplinePoint(const PathBuilder& path, double along_m,
                                  const PlanScenario& plan) {
  const Segment& s = path.At(along_m);
  const double into_m = along_m - s.begin_m;
  const Waypoint w = Advance(s.start, into_m, s.curvature_per_m);
  const double speed_mps = path.SpeedAt(along_m);
  const double height_m = s.height0_m + (s.height1_m - s.height0_m) * ChangeDone(s, into_m);
  UniformSpline::Vector c;
  c << w.en_m, height_m, 0.0, 0.0, w.heading_rad + plan.crab_rad;
  if (!plan.stabilised_mount) {
    c[3] = std::atan(speed_mps * speed_mps * s.curvature_per_m / kStandardGravityMps2);
  }
  return c;
}

/// Sets the pitch of the control points to the slope of the path.
void PitchAlongPath(std::vector<UniformSpline::Vector>& control) {
  for (std::size_t i = 1; i + 1 < control.size(); ++i) {
    const Eigen::Vector3d d = (control[i + 1] - control[i - 1]).head<3>();
    control[i][4] = std::atan2(d.z(), d.head<2>().norm());
  }
}

/// Path with warm-up, lines and run-out, and the strips as intervals of path length.
struct Course {
  PathBuilder path;
  std::vector<Vector2d> strips_m;
};

Course LayOut(const PlanScenario& plan, int warm_up_legs) {
  Course course{PathBuilder(plan.bank_rad), {}};
  for (int i = warm_up_legs; i-- > 0;) course.path.AddLeg(WarmUpLeg(plan, i));
  for (const PlannedLine& line : plan.lines) course.strips_m.push_back(course.path.AddLeg(line));
  course.path.AddLeg(RunOutLeg(plan.lines.back()));
  return course;
}

}  // namespace

FlightPlan PlanFlight(const PlanScenario& plan) {
  for (int legs = 0;; ++legs) {
    const Course course = LayOut(plan, legs);
    CheckDuration(course.path.LongestDuration());
    const Timetable times(course.path, course.path.segments().back().begin_m + 1.0);
    const double first_s = times.TimeAt(course.strips_m.front().x());
    if (first_s < plan.warm_up_s) continue;

    const double begin_s = first_s - plan.warm_up_s;
    const auto strip_s = [&](double along_m) { return times.TimeAt(along_m) - begin_s; };
    std::vector<Vector2d> strips_s;
    for (const Vector2d& strip : course.strips_m) {
      strips_s.emplace_back(strip_s(strip.x()), strip_s(strip.y()));
    }
    const double duration_s = std::ceil(strips_s.back().y() + kRunOut_s);
    std::vector<UniformSpline::Vector> control;
    const auto count = static_cast<int>((duration_s + 2.0 * kPathMargin_s) / kPathStep_s) + 1;
    for (int i = 0; i < count; ++i) {
      const double t_s = begin_s - kPathMargin_s + kPathStep_s * i;
      control.push_back(SplinePoint(course.path, times.LengthAt(t_s), plan));
    }
    PitchAlongPath(control);
    if (plan.stabilised_mount) {
      for (UniformSpline::Vector& c : control) c[4] = 0.0;
    }
    double speed_mps = 0.0;
    for (const PlannedLine& line : plan.lines) speed_mps += line.speed_mps;
    return {UniformSpline(-kPathMargin_s, kPathStep_s, std::move(control)), duration_s,
            speed_mps / static_cast<double>(plan.lines.size()), std::move(strips_s)};
  }
}

}  // namespace dn
