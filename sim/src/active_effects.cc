#include "active_effects.h"

#include <dn/effects/effect_table.h>
#include <dn/error.h>

#include <algorithm>
#include <cmath>

#include "effects/registry.h"

namespace dn {

Eigen::Vector3d TurnedTowardAxis(const Eigen::Vector3d& axis, double angle_rad,
                                 const Eigen::Vector3d& u) {
  const double along = axis.dot(u);
  const Eigen::Vector3d across = u - along * axis;
  const double c = std::cos(angle_rad), s = std::sin(angle_rad);
  const double length = across.norm();
  return (along * c + length * s) * axis + (c - along / length * s) * across;
}

double ScanLean(const ActiveEffects& effects, const LidarScenario& lidar,
                const Eigen::Vector3d& u_s) {
  if (effects.scan_lean_rad.empty()) return 0.0;
  const Eigen::Vector3d axis_s = lidar.scan_axis_s.normalized();
  const Eigen::Vector3d in_plane_s = u_s - axis_s.dot(u_s) * axis_s;
  const double angle_rad = std::atan2(in_plane_s.dot(axis_s.cross(lidar.nadir_axis_s)),
                                      in_plane_s.dot(lidar.nadir_axis_s));
  double lean_rad = 0.0;
  for (const auto& more_rad : effects.scan_lean_rad) lean_rad += more_rad(angle_rad);
  return lean_rad;
}

LidarSpan LidarEpochSpan(const std::vector<StripInterval>& strips) {
  if (strips.empty()) return {};
  LidarSpan span{strips.front().t0_s, strips.front().t1_s};
  for (const StripInterval& strip : strips) {
    span = {std::min(span.first_s, strip.t0_s), std::max(span.last_s, strip.t1_s)};
  }
  return span;
}

LidarSpan LidarEpochSpan(const std::vector<LidarPair>& pairs) {
  if (pairs.empty()) return {};
  LidarSpan span{pairs.front().t_i_s, pairs.front().t_i_s};
  for (const LidarPair& pair : pairs) {
    span.first_s = std::min({span.first_s, pair.t_i_s, pair.t_j_s});
    span.last_s = std::max({span.last_s, pair.t_i_s, pair.t_j_s});
  }
  return span;
}

ActiveEffects MakeActiveEffects(const Scenario& scenario, std::uint64_t seed, bool noise) {
  ActiveEffects active;
  for (const SimulatedEffect& simulated : SimulatedEffects()) {
    const EffectSpec& row = EffectRow(simulated.id);
    int index = 0;
    for (const Effect& effect : scenario.effects) {
      if (effect.name != row.name) continue;
      std::string stream = effect.name + " " + std::to_string(index++);
      if (row.sensor == EffectSensor::kLidar && !scenario.lidar.name.empty()) {
        stream += " " + scenario.lidar.name;
      }
      if (!noise && row.random()) continue;
      simulated.activate({scenario, effect, ValueInSi(row, effect.value), seed, stream}, &active);
    }
  }
  return active;
}

void AddOwnErrors(const OwnErrors& own, const std::shared_ptr<const TruthTrajectory>& truth,
                  ActiveEffects* active) {
  if (own.gyro_radps) {
    active->triads.emplace_back(
        [error_radps = own.gyro_radps](const ImuSample&, ImuSample* sample) {
          sample->w_ib_b_radps += error_radps(sample->t_s);
        });
  }
  if (own.specific_force_mps2) {
    active->triads.emplace_back(
        [error_mps2 = own.specific_force_mps2](const ImuSample&, ImuSample* sample) {
          sample->f_b_mps2 += error_mps2(sample->t_s);
        });
  }
  if (own.antenna_enu_m) {
    active->antenna_enu_m.emplace_back(
        [error_enu_m = own.antenna_enu_m](double t_s, double) { return error_enu_m(t_s); });
  }
  if (own.boresight_rad) {
    active->boresight_rad.emplace_back(
        [more_rad = own.boresight_rad, truth](double t_s, const LidarSpan&) {
          return more_rad(truth->Pose(t_s));
        });
  }
  if (own.laser_vector) active->laser_vector.push_back(own.laser_vector);
  if (own.lidar_tag_shift_s) {
    active->lidar_tag_shift_s.emplace_back(
        [shift_s = own.lidar_tag_shift_s](double t_s, const LidarSpan&) { return shift_s(t_s); });
  }
  if (own.pairs) active->all_pairs.push_back(own.pairs);
}

void RefuseStepBack(const std::vector<TagShift>& shifts, double before_s, double t_s) {
  for (const TagShift& shift : shifts) {
    if (shift.shift_s(t_s) < shift.shift_s(before_s)) {
      throw InvalidConfig(shift.effect + ": the time tags would step back", shift.where);
    }
  }
  throw InvalidInput("the time tags would step back");
}

double Tag(const std::vector<TagShift>& shifts, double t_s) {
  double tag_s = t_s;
  for (const TagShift& shift : shifts) tag_s += shift.shift_s(t_s);
  return tag_s;
}

bool InGap(const std::vector<DataGap>& gaps, double t_s) {
  for (const DataGap& gap : gaps) {
    if (gap.times.During(t_s)) return true;
  }
  return false;
}

}  // namespace dn
