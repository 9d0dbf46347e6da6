#include "lidar_effects.h"

#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

namespace dn::internal {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

constexpr double kPpm = 1e-6;
constexpr double kDegPerHour = kRadPerDeg / 3600.0;
constexpr std::size_t kMostSteps = 6;

/// d residual / d effect by one end.
using EndModel = std::function<MatrixXd(const PairEnd&)>;

EffectModel ModelOf(const std::vector<PairEnds>& pairs, const EndModel& end) {
  EffectModel model;
  for (const PairEnds& pair : pairs) model.push_back({pair.factor, end(pair.i) + end(pair.j)});
  return model;
}

MatrixXd ByBoresight(const PairEnd& end) { return -end.J_r_u * Skew(end.u_b); }

/// Times between strips at which the mount may have slipped.
std::vector<double> TimesOfSteps(std::vector<StripInterval> strips) {
  std::sort(strips.begin(), strips.end(),
            [](const StripInterval& a, const StripInterval& b) { return a.t0_s < b.t0_s; });
  std::vector<double> t_s;
  for (std::size_t k = 1; k < strips.size(); ++k) {
    t_s.push_back(0.5 * (strips[k - 1].t1_s + strips[k].t0_s));
  }
  if (t_s.size() > kMostSteps) {
    std::vector<double> some;
    for (std::size_t k = 0; k < kMostSteps; ++k) some.push_back(t_s[k * t_s.size() / kMostSteps]);
    return some;
  }
  return t_s;
}

struct TimeSpan {
  double first_s = std::numeric_limits<double>::infinity();
  double last_s = -std::numeric_limits<double>::infinity();
};

TimeSpan SpanOf(const std::vector<PairEnds>& pairs) {
  TimeSpan span;
  for (const PairEnds& pair : pairs) {
    span.first_s = std::min({span.first_s, pair.i.t_s, pair.j.t_s});
    span.last_s = std::max({span.last_s, pair.i.t_s, pair.j.t_s});
  }
  return span;
}

void AddRangesAndAngles(const std::vector<PairEnds>& pairs, std::vector<CandidateEffect>* effects) {
  const std::string ranges = "correct the ranges of the pair files (lidar.p2p) and their unit";
  effects->push_back(MakeEffect(
      "lidar_range_offset", "m", 1.0, 1, 0.02, ranges,
      ModelOf(pairs, [](const PairEnd& e) -> MatrixXd { return -e.J_r_u * e.u_b.normalized(); })));
  effects->push_back(
      MakeEffect("lidar_range_scale", "ppm", kPpm, 1, 100.0, ranges,
                 ModelOf(pairs, [](const PairEnd& e) -> MatrixXd { return -e.J_r_u * e.u_b; })));
  effects->push_back(
      MakeEffect("lidar_angle_scale", "ppm", kPpm, 1, 500.0,
                 "correct the scan angles of the laser vectors in the pair files (lidar.p2p)",
                 ModelOf(pairs, [](const PairEnd& e) -> MatrixXd {
                   return -e.J_r_u * (e.scan_angle_rad * e.axis_b.cross(e.u_b));
                 })));
  effects->push_back(MakeEffect(
      "lidar_scan_cone", "deg", kRadPerDeg, 1, 0.02,
      "the beam leaves the scan plane: correct the laser vectors in the pair files (lidar.p2p)",
      ModelOf(pairs,
              [](const PairEnd& e) -> MatrixXd { return e.J_r_u * (e.u_s.norm() * e.axis_b); })));
}

}  // namespace

PairEnd MakePairEnd(const LidarConfig& lidar, const Eigen::Quaterniond& q_boresight, double t_s,
                    const Vector3d& u_s) {
  PairEnd end;
  end.t_s = t_s;
  end.u_s = u_s;
  end.u_b = q_boresight * (lidar.mounting.R_bs_nominal * u_s);
  end.axis_b = q_boresight * (lidar.mounting.R_bs_nominal * lidar.scan_axis_s.normalized());
  end.scan_angle_rad =
      std::atan2(u_s.dot(lidar.scan_axis_s.cross(lidar.nadir_axis_s)), u_s.dot(lidar.nadir_axis_s));
  return end;
}

EffectModel TimeOffsetModel(const std::vector<PairEnds>& pairs) {
  return ModelOf(pairs, [](const PairEnd& e) -> MatrixXd { return e.J_r_t; });
}

EffectModel LeverArmModel(const std::vector<PairEnds>& pairs) {
  return ModelOf(pairs, [](const PairEnd& e) -> MatrixXd { return e.J_r_u; });
}

CandidateEffect MakeEffect(const std::string& name, const std::string& unit, double unit_si,
                           int components, double typical, const std::string& remedy,
                           EffectModel model) {
  return {name,          unit,
          1.0 / unit_si, Eigen::VectorXd::Constant(components, typical * unit_si),
          remedy,        std::move(model)};
}

CandidateEffect TimeOffset(const std::string& remedy, EffectModel model) {
  return MakeEffect("lidar_time_offset", "s", 1.0, 1, 5e-4, remedy, std::move(model));
}

CandidateEffect LeverArm(const std::string& remedy, EffectModel model) {
  return MakeEffect("lidar_lever_arm", "m", 1.0, 3, 0.03, remedy, std::move(model));
}

void AddEffectsOfScanner(const std::vector<PairEnds>& pairs,
                         std::vector<CandidateEffect>* effects) {
  const double first_s = SpanOf(pairs).first_s;
  effects->push_back(MakeEffect(
      "lidar_time_drift", "ppm", kPpm, 1, 1.0,
      "the clock of the scanner drifts: correct the time tags of the pair files",
      ModelOf(pairs, [&](const PairEnd& e) -> MatrixXd { return e.J_r_t * (e.t_s - first_s); })));
  AddRangesAndAngles(pairs, effects);
}

void AddMovesOfMount(const std::vector<PairEnds>& pairs, const std::vector<StripInterval>& strips,
                     std::vector<CandidateEffect>* effects) {
  const std::string mount = "the scanner moves against the inertial unit: fix its mount";
  const TimeSpan span = SpanOf(pairs);
  const double middle_s = 0.5 * (span.first_s + span.last_s);
  effects->push_back(MakeEffect("boresight_drift", "deg/h", kDegPerHour, 3, 0.02, mount,
                                ModelOf(pairs, [&](const PairEnd& e) -> MatrixXd {
                                  return ByBoresight(e) * (e.t_s - middle_s);
                                })));
  for (const double t0_s : TimesOfSteps(strips)) {
    effects->push_back(MakeEffect("boresight_step", "deg", kRadPerDeg, 3, 0.005, mount,
                                  ModelOf(pairs, [&](const PairEnd& e) -> MatrixXd {
                                    return (e.t_s > t0_s ? 1.0 : 0.0) * ByBoresight(e);
                                  })));
  }
}

}  // namespace dn::internal
