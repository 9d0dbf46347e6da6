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
constexpr int kTrialsPerPoint = 1000, kTrialsPerCorner = 20000;
constexpr double kCornerReachM = 3.0;  // part of the roof around a corner that must be free
constexpr double kRoundingM = 1e-3;
constexpr double kLeastCosine = 0.25;  // of the angle between a ray and the normal of a surface

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

  /// Draws a point on the ground with a laser return.
  ControlPoint DrawPoint() {
    for (int trial = 0; trial < kTrialsPerPoint; ++trial) {
      const Place place = DrawPlace();
      if (terrain_.Water(place.en_m)) continue;
      const Vector3d point_m(place.en_m.x(), place.en_m.y(), terrain_.Surface(place.en_m));
      const auto seen = See(*place.strip, point_m);
      if (!seen.empty()) return Measured(point_m, seen.front());
    }
    throw InvalidConfig("the strips of scenario '" + scenario_.name +
                        "' see no ground for control points; set control: {points: 0, checks: 0}");
  }

  /// Draws the peak of a gable that differs from those drawn before.
  ControlPoint DrawCorner() {
    for (int trial = 0; trial < kTrialsPerCorner; ++trial) {
      const std::optional<Gable> gable =
          terrain_.GableAt(DrawPlace().en_m, random_.Uniform() < 0.5);
      if (!gable) continue;
      const bool is_new = std::none_of(peaks_m_.begin(), peaks_m_.end(),
                                       [&](const Vector3d& peak) { return peak == gable->peak_m; });
      if (!is_new || !IsFree(*gable) || !IsSeen(*gable)) continue;
      peaks_m_.push_back(gable->peak_m);
      ControlPoint point = Surveyed(gable->peak_m);
      point.is_corner = true;
      return point;
    }
    throw InvalidConfig("the strips of scenario '" + scenario_.name +
                        "' see too few gables for the corners of control; fly over a terrain with "
                        "houses, or set fewer corners");
  }

 private:
  /// A place beside the path of a strip.
  struct Place {
    const StripInterval* strip;
    Vector2d en_m;
  };

  Place DrawPlace() {
    const auto index =
        static_cast<std::size_t>(random_.Uniform() * static_cast<double>(strips_.size()));
    const StripInterval& strip = strips_[index];
    const MapPose at = truth_.Pose(random_.Uniform(strip.t0_s, strip.t1_s));
    const Vector2d along = at.v_m.head<2>().normalized();
    const double above_m = at.p_mb.z() - terrain_.Surface(at.p_mb.head<2>());
    const double half_width_m =
        above_m * std::tan(kInnerShare * std::min(0.5 * scenario_.lidar.fov_rad, 1.2));
    const double across_m = half_width_m * random_.Uniform(-1.0, 1.0);
    return {&strip, at.p_mb.head<2>() + across_m * Vector2d(-along.y(), along.x())};
  }

  std::vector<Sighting> See(const StripInterval& strip, const Vector3d& point_m) const {
    return scanner_.See(point_m, truth_.Pose(strip.t0_s), truth_.Pose(strip.t1_s));
  }

  /// Returns whether no tree or other house covers the roof near the peak.
  bool IsFree(const Gable& gable) const {
    const double width_m = std::min(kCornerReachM, 0.9 * gable.half_width_m);
    for (const double back_m : {0.1, 0.5 * kCornerReachM, kCornerReachM}) {
      for (const double left_m : {-width_m, -0.5 * width_m, 0.5 * width_m, width_m}) {
        const Vector3d roof_m = gable.OnRoof(back_m, left_m);
        if (std::abs(terrain_.Surface(roof_m.head<2>()) - roof_m.z()) > kRoundingM) return false;
      }
    }
    return true;
  }

  /// Returns whether strips see both sides of the roof and the wall, as a surveyor chooses them.
  bool IsSeen(const Gable& gable) const {
    const double width_m = 0.5 * std::min(kCornerReachM, gable.half_width_m);
    Vector3d wall_m = gable.peak_m - Vector3d(0.0, 0.0, width_m);
    wall_m.head<2>() += kRoundingM * gable.outward;
    const Vector3d outward(gable.outward.x(), gable.outward.y(), 0.0);
    return IsSeen(gable.OnRoof(1.0, width_m), Vector3d::UnitZ()) &&
           IsSeen(gable.OnRoof(1.0, -width_m), Vector3d::UnitZ()) && IsSeen(wall_m, outward);
  }

  /// Returns whether a strip sees a point of a surface with this normal, and not at a glance.
  bool IsSeen(const Vector3d& point_m, const Vector3d& normal) const {
    for (const StripInterval& strip : strips_) {
      for (const Sighting& sighting : See(strip, point_m)) {
        const Vector3d ray_m = truth_.Pose(sighting.t_s).p_mb - point_m;
        if (ray_m.normalized().dot(normal) >= kLeastCosine) return true;
      }
    }
    return false;
  }

  ControlPoint Surveyed(const Vector3d& point_m) {
    const double noise = options_.noise ? 1.0 : 0.0;
    const Vector3d& sigma_m = scenario_.control.sigma_enu_m;
    ControlPoint point;
    point.p_m = point_m + noise * sigma_m.cwiseProduct(random_.Normal3());
    point.covariance_m2 = sigma_m.cwiseAbs2().asDiagonal();
    return point;
  }

  ControlPoint Measured(const Vector3d& point_m, const Sighting& sighting) {
    const double noise = options_.noise ? 1.0 : 0.0;
    ControlPoint point = Surveyed(point_m);
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
  std::vector<Vector3d> peaks_m_;
};

}  // namespace

ControlData SimulateControl(const Scenario& scenario, const std::vector<StripInterval>& strips,
                            const std::shared_ptr<const TruthTrajectory>& truth,
                            const std::shared_ptr<const Terrain>& terrain,
                            const ControlSimulation& options, const ActiveEffects& effects) {
  PointSampler sampler(scenario, strips, truth, terrain, options, effects);
  ControlData data;
  const ControlScenario& control = scenario.control;
  const auto add = [&](ControlPoint point, const std::string& name, bool is_check) {
    point.name = name;
    point.is_check = is_check;
    data.points.push_back(std::move(point));
  };
  for (const bool check : {false, true}) {
    for (long k = 1; k <= (check ? control.checks : control.points); ++k) {
      add(sampler.DrawPoint(), (check ? "C" : "P") + std::to_string(k), check);
    }
  }
  for (const bool check : {false, true}) {
    for (long k = 1; k <= (check ? control.corner_checks : control.corners); ++k) {
      add(sampler.DrawCorner(), (check ? "CG" : "G") + std::to_string(k), check);
    }
  }
  return data;
}

}  // namespace dn
