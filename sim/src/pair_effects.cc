#include "pair_effects.h"

#include <dn/sim/random.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <string>

#include "effects.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kPpm = 1e-6;

void AddOutliers(const Effect& effect, Random& random, PairData* data) {
  for (LidarPair& pair : data->pairs) {
    const bool wrong = random.Uniform() < effect.value[0];
    const double length_m = effect.value[1] * random.Uniform();
    const Vector3d direction = random.Normal3().normalized();
    if (wrong) pair.u_j_s += length_m * direction;
  }
}

}  // namespace

double PairNoiseRatio(const Scenario& scenario, double mean_range_m) {
  const double per_m = 1e-3 * ScalarEffect(scenario, "p2p_range_noise");
  const double grown = per_m * mean_range_m / scenario.pairs.sigma_p_m;
  return RatioEffect(scenario, "p2p_noise_scale") * std::sqrt(1.0 + grown * grown);
}

Eigen::Vector3d Distort(const Scenario& scenario, const Eigen::Vector3d& u_s_m) {
  const LidarScenario& lidar = scenario.lidar;
  const double angle_scale = kPpm * ScalarEffect(scenario, "lidar_angle_scale");
  const double range_scale = kPpm * ScalarEffect(scenario, "lidar_range_scale");
  const double offset_m = ScalarEffect(scenario, "lidar_range_offset");
  if (angle_scale == 0.0 && range_scale == 0.0 && offset_m == 0.0) return u_s_m;
  const double angle = std::atan2(u_s_m.dot(lidar.scan_axis_s.cross(lidar.nadir_axis_s)),
                                  u_s_m.dot(lidar.nadir_axis_s));
  const Vector3d turned =
      Eigen::AngleAxisd(angle_scale * angle, lidar.scan_axis_s.normalized()) * u_s_m;
  return ((1.0 + range_scale) + offset_m / u_s_m.norm()) * turned;
}

void ApplyPairEffects(const Scenario& scenario, std::uint64_t seed, bool noise, PairData* data) {
  int entry = 0;
  for (const Effect* outliers : EffectsNamed(scenario, "p2p_outliers")) {
    Random random(seed, outliers->name + " " + std::to_string(entry++));
    if (noise) AddOutliers(*outliers, random, data);
  }
  const double drift = kPpm * ScalarEffect(scenario, "lidar_time_drift");
  if (drift == 0.0 || data->pairs.empty()) return;
  double first_s = data->pairs.front().t_i_s;
  for (const LidarPair& pair : data->pairs) first_s = std::min({first_s, pair.t_i_s, pair.t_j_s});
  for (LidarPair& pair : data->pairs) {
    pair.t_i_s += drift * (pair.t_i_s - first_s);
    pair.t_j_s += drift * (pair.t_j_s - first_s);
  }
}

}  // namespace dn
