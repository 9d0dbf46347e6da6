#include "control_simulation.h"

#include <dn/error.h>
#include <dn/sim/random.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string>

#include "scanner.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Part of the half field of view within which points lie, so that roll keeps them in view.
constexpr double kInnerShare = 0.8;
constexpr int kTrialsPerPoint = 1000;

class PointSampler {
 public:
  PointSampler(const Scenario& scenario, const std::vector<StripInterval>& strips,
               const std::shared_ptr<const TruthTrajectory>& truth,
               const std::shared_ptr<const Terrain>& terrain, const ControlSimulation& options,
               const ActiveEffects& effects)
      : scenario_(scenario),
        strips_(strips),
        truth_(*truth),
        terrain_(*terrain),
        options_(options),
        effects_(effects),
        scanner_(scenario.lidar, effects, options.span, truth, terrain),
        random_(options.seed, "control") {}

  ControlPoint Draw(const std::string& name, bool is_check) {
    for (int trial = 0; trial < kTrialsPerPoint; ++trial) {
      if (auto point = Try()) {
        point->name = name;
        point->is_check = is_check;
        return *point;
      }
    }
    throw InvalidConfig("the strips of scenario '" + scenario_.name +
                        "' see no ground for control points; set control: {points: 0, checks: 0}");
  }

 private:
  /// Draws a ground point beside the path of a strip; nullopt if the strip does not see it.
  std::optional<ControlPoint> Try() {
    const auto index =
        static_cast<std::size_t>(random_.Uniform() * static_cast<double>(strips_.size()));
    const StripInterval& strip = strips_[index];
    const MapPose at = truth_.Pose(random_.Uniform(strip.t0_s, strip.t1_s));
    const Vector2d along = at.v_m.head<2>().normalized();
    const double above_m = at.p_mb.z() - terrain_.Surface(at.p_mb.head<2>());
    const double half_width_m =
        above_m * std::tan(kInnerShare * std::min(0.5 * scenario_.lidar.fov_rad, 1.2));
    const double across_m = half_width_m * random_.Uniform(-1.0, 1.0);
    const Vector2d en_m = at.p_mb.head<2>() + across_m * Vector2d(-along.y(), along.x());
    if (terrain_.Water(en_m)) return std::nullopt;
    const Vector3d point_m(en_m.x(), en_m.y(), terrain_.Surface(en_m));
    const auto seen = scanner_.See(point_m, truth_.Pose(strip.t0_s), truth_.Pose(strip.t1_s));
    if (seen.empty()) return std::nullopt;
    return Measured(point_m, seen.front());
  }

  ControlPoint Measured(const Vector3d& point_m, const Sighting& sighting) {
    const double noise = options_.noise ? 1.0 : 0.0;
    const Vector3d& sigma_m = scenario_.control.sigma_enu_m;
    ControlPoint point;
    point.p_m = point_m + noise * sigma_m.cwiseProduct(random_.Normal3());
    point.covariance_m2 = sigma_m.cwiseAbs2().asDiagonal();
    ControlReturn one;
    one.u_s = sighting.u_s;
    for (const auto& measured : effects_.laser_vector) one.u_s = measured(one.u_s, sighting.t_s);
    one.u_s += noise * scenario_.pairs.sigma_p_m / std::numbers::sqrt2 * random_.Normal3();
    one.t_s = sighting.t_s;
    for (const auto& shift_s : effects_.lidar_tag_shift_s) {
      one.t_s += shift_s(sighting.t_s, options_.span);
    }
    point.returns.push_back(one);
    return point;
  }

  const Scenario& scenario_;
  const std::vector<StripInterval>& strips_;
  const TruthTrajectory& truth_;
  const Terrain& terrain_;
  const ControlSimulation& options_;
  const ActiveEffects& effects_;
  Scanner scanner_;
  Random random_;
};

}  // namespace

ControlData SimulateControl(const Scenario& scenario, const std::vector<StripInterval>& strips,
                            const std::shared_ptr<const TruthTrajectory>& truth,
                            const std::shared_ptr<const Terrain>& terrain,
                            const ControlSimulation& options, const ActiveEffects& effects) {
  PointSampler sampler(scenario, strips, truth, terrain, options, effects);
  ControlData data;
  const ControlScenario& control = scenario.control;
  for (long k = 0; k < control.points + control.checks; ++k) {
    const bool check = k >= control.points;
    const long number = 1 + (check ? k - control.points : k);
    data.points.push_back(sampler.Draw((check ? "C" : "P") + std::to_string(number), check));
  }
  return data;
}

}  // namespace dn
