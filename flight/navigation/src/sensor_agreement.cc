#include <dn/axis_rotations.h>
#include <dn/builder/gnss_factors.h>
#include <dn/builder/node_grid.h>
#include <dn/median.h>
#include <dn/navigation/sensor_agreement.h>
#include <dn/parallel.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "in_flight_alignment.h"

namespace dn {
namespace {

using Eigen::Vector3d;
using navigation_internal::Antenna;

constexpr double kShortestWindowS = 30.0;
constexpr double kMostSigmaHeadingRad = 15.0 * kRadPerDeg;
// A slower body is not assumed to move forward: it may be carried sideways.
constexpr double kLeastSpeedMps = 2.0;
// A course with a larger noise is not used.
constexpr double kMostCourseNoiseRad = 0.1;
constexpr double kLeastTurnS = 2.0;
constexpr double kMostLagS = 40.0;
constexpr double kLagStepS = 0.25;
// The right axes leave at most this share of the misfit of all other axes.
constexpr double kExplainedMisfit = 0.5;
constexpr double kAngleSpacingS = 0.05;  // turns last at least kLeastTurnS

/// Mean velocity of the antenna over a time step, map axes.
struct Leg {
  double t_begin_s;
  double t_end_s;
  Vector3d v_m;
};

std::vector<Leg> LegsWithLength(const std::vector<Antenna>& track, double length_s) {
  std::vector<Leg> legs;
  for (std::size_t i = 0, j = 0; i < track.size(); i = j) {
    while (j < track.size() && track[j].t_s - track[i].t_s < length_s - 1e-3) ++j;
    if (j == track.size()) break;
    legs.push_back({track[i].t_s, track[j].t_s,
                    (track[j].p_m - track[i].p_m) / (track[j].t_s - track[i].t_s)});
  }
  return legs;
}

/// Returns the median speed of the moving legs, m/s; kLeastSpeedMps if no leg moves.
double TypicalSpeed(const std::vector<Leg>& legs) {
  std::vector<double> speeds;
  for (const Leg& leg : legs) {
    const double speed = leg.v_m.head<2>().norm();
    if (speed > kLeastSpeedMps) speeds.push_back(speed);
  }
  return speeds.empty() ? kLeastSpeedMps : Median(speeds);
}

/// Returns legs that are long enough for a course noise of at most kMostCourseNoiseRad.
std::vector<Leg> Legs(const Flight& flight, const std::vector<Antenna>& track, double shortest_s) {
  const double noise_s_mps = std::numbers::sqrt2 * TypicalGnssSigma(flight) / kMostCourseNoiseRad;
  const double usual_mps =
      TypicalSpeed(LegsWithLength(track, std::max(shortest_s, noise_s_mps / kLeastSpeedMps)));
  return LegsWithLength(track, std::max(shortest_s, noise_s_mps / usual_mps));
}

std::vector<Antenna> WholeTrack(const Flight& flight) {
  return navigation_internal::AntennaTrack(flight,
                                           {flight.imu->t_begin_s(), flight.imu->t_end_s()});
}

/// Returns the moving legs, at least half a window apart.
std::vector<Leg> SpacedLegs(const Flight& flight, double window_s) {
  std::vector<Leg> spaced;
  for (const Leg& leg : Legs(flight, WholeTrack(flight), 1.0)) {
    if (leg.v_m.head<2>().norm() < kLeastSpeedMps) continue;
    const bool near = !spaced.empty() && leg.t_begin_s < spaced.back().t_begin_s + 0.5 * window_s;
    if (!near) spaced.push_back(leg);
  }
  return spaced;
}

/// Returns the course of a leg in body axes from an alignment over the window that begins with the
/// leg. Returns nullopt if the window does not determine the attitude.
std::optional<Vector3d> CourseInBody(const Flight& flight, const Leg& leg, double window_s) {
  const navigation_internal::InFlight start =
      navigation_internal::AlignInFlight(flight, {leg.t_begin_s, leg.t_begin_s + window_s}, {});
  if (!start.valid || start.sigma_heading_rad > kMostSigmaHeadingRad) return std::nullopt;
  Vector3d course_m = leg.v_m;
  course_m.z() = 0.0;
  return start.q_mb.conjugate() * course_m.normalized();
}

double WindowLength(const Flight& flight) {
  return std::max(kShortestWindowS, 8.0 * navigation_internal::AlignmentSpacing(flight));
}

/// Returns the mean misfit of the alignments in windows, m/s^2; nullopt if fewer than three are
/// valid.
std::optional<double> MeanMisfit(const Flight& flight, const std::vector<Leg>& legs, int threads) {
  const double window_s = WindowLength(flight);
  std::vector<navigation_internal::InFlight> starts(legs.size());
  ParallelFor(static_cast<int>(legs.size()), threads, [&](int at) {
    const auto k = static_cast<std::size_t>(at);
    const TimeInterval window{legs[k].t_begin_s, legs[k].t_begin_s + window_s};
    const bool covered =
        window.t0_s >= flight.imu->t_begin_s() && window.t1_s <= flight.imu->t_end_s();
    if (covered) starts[k] = navigation_internal::AlignInFlight(flight, window, {});
  });
  double sum = 0.0, n = 0.0;
  for (const navigation_internal::InFlight& start : starts) {
    if (!start.valid) continue;
    sum += start.misfit_mps2;
    n += 1.0;
  }
  return n < 3.0 ? std::nullopt : std::optional(sum / n);
}

/// Returns all mistakes that FindAxesMistake distinguishes.
std::vector<AxesMistake> AllAxesMistakes() {
  using Sensor = AxesMistake::Sensor;
  std::vector<AxesMistake> mistakes{{Sensor::kBoth, -Eigen::Matrix3d::Identity()},
                                    {Sensor::kGyro, kDegPerRad * Eigen::Matrix3d::Identity()},
                                    {Sensor::kGyro, kRadPerDeg * Eigen::Matrix3d::Identity()}};
  for (const Sensor sensor : {Sensor::kGyro, Sensor::kAccel}) {
    mistakes.push_back({sensor, -Eigen::Matrix3d::Identity()});
    for (int axis = 0; axis < 3; ++axis) {
      AxesMistake sign{sensor}, exchange{sensor};
      sign.M(axis, axis) = -1.0;
      exchange.M.row(axis).swap(exchange.M.row((axis + 1) % 3));
      mistakes.push_back(sign);
      mistakes.push_back(exchange);
    }
  }
  return mistakes;
}

void Undo(const AxesMistake& mistake, ImuData* imu, const Eigen::Matrix3d& R_imu_to_body) {
  const Eigen::Matrix3d M_b = R_imu_to_body * mistake.M * R_imu_to_body.transpose();
  for (ImuSample& sample : imu->samples) {
    if (mistake.sensor != AxesMistake::Sensor::kAccel) {
      sample.w_ib_b_radps = M_b * sample.w_ib_b_radps;
    }
    if (mistake.sensor != AxesMistake::Sensor::kGyro) sample.f_b_mps2 = M_b * sample.f_b_mps2;
  }
}

std::vector<Vector3d> CoursesInBody(const Flight& flight, int threads) {
  const double window_s = WindowLength(flight);
  const std::vector<Leg> legs = SpacedLegs(flight, window_s);
  std::vector<std::optional<Vector3d>> of_leg(legs.size());
  ParallelFor(static_cast<int>(legs.size()), threads, [&](int at) {
    const auto k = static_cast<std::size_t>(at);
    of_leg[k] = CourseInBody(flight, legs[k], window_s);
  });
  std::vector<Vector3d> courses;
  for (const std::optional<Vector3d>& course : of_leg) {
    if (course) courses.push_back(*course);
  }
  return courses;
}

BodyDirections MeanDownDirection(const ImuData& imu) {
  BodyDirections result;
  Vector3d sum = Vector3d::Zero();
  double lengths = 0.0;
  for (const ImuSample& sample : imu.samples) {
    sum += sample.f_b_mps2;
    lengths += sample.f_b_mps2.norm();
  }
  if (!(sum.norm() > 0.0)) return result;
  result.down_b = -sum.normalized();
  result.down_agreement = sum.norm() / lengths;
  return result;
}

/// Angle turned about an axis since the first sample, at the ends of samples.
struct TurnedAngle {
  std::vector<double> t_s, angle_rad;

  TurnedAngle(const ImuData& imu, const Vector3d& axis_b) {
    double angle = 0.0;
    for (const ImuSample& sample : imu.samples) {
      angle += sample.dt_s * axis_b.dot(sample.w_ib_b_radps);
      if (!t_s.empty() && sample.t_s < t_s.back() + kAngleSpacingS) continue;
      t_s.push_back(sample.t_s);
      angle_rad.push_back(angle);
    }
  }

  bool Covers(double t) const { return t >= t_s.front() && t <= t_s.back(); }
};

/// Interpolates angles at times in ascending order.
class AngleCursor {
 public:
  explicit AngleCursor(const TurnedAngle& gyro) : gyro_(gyro) {}

  double At(double t) {
    const std::vector<double>& t_s = gyro_.t_s;
    if (!placed_) k_ = static_cast<std::size_t>(std::ranges::lower_bound(t_s, t) - t_s.begin());
    placed_ = true;
    while (t_s[k_] < t) ++k_;
    if (k_ == 0) return gyro_.angle_rad.front();
    const double share = (t - t_s[k_ - 1]) / (t_s[k_] - t_s[k_ - 1]);
    return gyro_.angle_rad[k_ - 1] + share * (gyro_.angle_rad[k_] - gyro_.angle_rad[k_ - 1]);
  }

 private:
  const TurnedAngle& gyro_;
  std::size_t k_ = 0;  // index of the first entry that is not earlier than t
  bool placed_ = false;
};

/// A change of the course between the middles of two legs.
struct Turn {
  double t_begin_s;
  double t_end_s;
  double angle_rad;  ///< clockwise from above
};

std::vector<Turn> CourseTurns(const Flight& flight) {
  const std::vector<Leg> legs = Legs(flight, WholeTrack(flight), kLeastTurnS);
  std::vector<Turn> turns;
  for (std::size_t i = 1; i < legs.size(); ++i) {
    const Eigen::Vector2d u = legs[i - 1].v_m.head<2>(), v = legs[i].v_m.head<2>();
    if (u.norm() < kLeastSpeedMps || v.norm() < kLeastSpeedMps) continue;
    turns.push_back({0.5 * (legs[i - 1].t_begin_s + legs[i - 1].t_end_s),
                     0.5 * (legs[i].t_begin_s + legs[i].t_end_s),
                     std::atan2(u.y() * v.x() - u.x() * v.y(), u.dot(v))});
  }
  return turns;
}

/// Correlation of the turns of the course with those of the gyros. A constant gyro bias has no
/// influence.
class TurnCorrelation {
 public:
  void Add(double x, double y) {
    n_ += 1;
    sx_ += x;
    sy_ += y;
    sxx_ += x * x;
    syy_ += y * y;
    sxy_ += x * y;
  }

  double Value() const {
    const double vx = sxx_ - sx_ * sx_ / n_, vy = syy_ - sy_ * sy_ / n_;
    return n_ >= 3 && vx > 0 && vy > 0 ? (sxy_ - sx_ * sy_ / n_) / std::sqrt(vx * vy) : 0.0;
  }

 private:
  double n_ = 0, sx_ = 0, sy_ = 0, sxx_ = 0, syy_ = 0, sxy_ = 0;
};

// Number of lags from kMostLagS down to -kMostLagS.
constexpr int kLags = static_cast<int>(2.0 * kMostLagS / kLagStepS) + 1;

double LagSeconds(int step) { return kMostLagS - step * kLagStepS; }

/// Returns the correlation of the turns with those of the gyros for each lag, from kMostLagS down
/// to -kMostLagS.
std::vector<TurnCorrelation> CorrelationsByLag(const std::vector<Turn>& turns,
                                               const TurnedAngle& gyro) {
  std::vector<TurnCorrelation> by_lag(kLags);
  for (const Turn& turn : turns) {
    AngleCursor begin(gyro), end(gyro);
    const double length_s = turn.t_end_s - turn.t_begin_s;
    for (int step = 0; step < kLags; ++step) {
      const double t0_s = turn.t_begin_s - LagSeconds(step), t1_s = turn.t_end_s - LagSeconds(step);
      if (!gyro.Covers(t0_s) || !gyro.Covers(t1_s)) continue;
      by_lag[static_cast<std::size_t>(step)].Add(turn.angle_rad / length_s,
                                                 (end.At(t1_s) - begin.At(t0_s)) / length_s);
    }
  }
  return by_lag;
}

double TiltTo(const Eigen::Matrix3d& R, const BodyDirections& directions) {
  const double down = std::acos(std::clamp((R * directions.down_b).z(), -1.0, 1.0));
  if (!directions.course_b) return down;
  return std::max(down, std::acos(std::clamp((R * *directions.course_b).x(), -1.0, 1.0)));
}

}  // namespace

BodyDirections FindBodyDirections(const Flight& flight, int threads) {
  BodyDirections result = MeanDownDirection(*flight.imu);
  if (!flight.gnss || result.down_agreement == 0.0) return result;
  const std::vector<Vector3d> courses = CoursesInBody(flight, threads);
  const Vector3d sum = std::accumulate(courses.begin(), courses.end(), Vector3d(Vector3d::Zero()));
  const Vector3d level = sum - result.down_b * result.down_b.dot(sum);
  if (courses.size() < 3 || !(level.norm() > 0.0)) return result;
  result.course_b = level.normalized();
  result.course_agreement = sum.norm() / static_cast<double>(courses.size());
  return result;
}

std::optional<AxesMistake> FindAxesMistake(const Flight& flight, int threads) {
  if (!flight.imu || !flight.gnss) return std::nullopt;
  const std::vector<Leg> legs = SpacedLegs(flight, WindowLength(flight));
  const std::optional<double> declared = MeanMisfit(flight, legs, threads);
  if (!declared) return std::nullopt;
  std::optional<AxesMistake> best;
  double least = *declared, second = *declared;
  Flight changed = flight;
  for (const AxesMistake& mistake : AllAxesMistakes()) {
    changed.imu->samples = flight.imu->samples;
    Undo(mistake, &*changed.imu, flight.config.imu->read.R_imu_to_body);
    const double misfit = MeanMisfit(changed, legs, threads).value_or(*declared);
    if (misfit < least) {
      second = std::exchange(least, misfit);
      best = mistake;
    } else {
      second = std::min(second, misfit);
    }
  }
  return least < kExplainedMisfit * second ? best : std::nullopt;
}

AxesFit FitAxes(const BodyDirections& directions) {
  AxesFit best{{}, 1e9};
  for (const Eigen::Matrix3d& R : AxisRotations()) {
    const double distance = TiltTo(R, directions);
    const bool nearer = distance < best.distance_rad - 1e-9;
    // Without a course several rotations fit. The smallest one is chosen, and among equals the one
    // that keeps x.
    const bool as_near = std::abs(distance - best.distance_rad) <= 1e-9;
    const auto kept = [](const Eigen::Matrix3d& M) { return M.trace() + 1e-3 * M(0, 0); };
    if (nearer || (as_near && kept(R) > kept(best.R_turn))) best = {R, distance};
  }
  return best;
}

std::optional<TurnComparison> CompareTurns(const Flight& flight) {
  const std::vector<Turn> turns = CourseTurns(flight);
  TurnComparison result;
  for (const Turn& turn : turns) result.turned_rad += std::abs(turn.angle_rad);
  if (turns.size() < 5 || result.turned_rad < std::numbers::pi) return std::nullopt;
  const TurnedAngle gyro(*flight.imu, MeanDownDirection(*flight.imu).down_b);
  const std::vector<TurnCorrelation> by_lag = CorrelationsByLag(turns, gyro);
  result.correlation = result.best_correlation = by_lag[kLags / 2].Value();
  for (int step = kLags - 1; step >= 0; --step) {
    const double correlation = by_lag[static_cast<std::size_t>(step)].Value();
    if (std::abs(correlation) <= std::abs(result.best_correlation)) continue;
    result.best_correlation = correlation;
    result.best_lag_s = LagSeconds(step);
  }
  return result;
}

}  // namespace dn
