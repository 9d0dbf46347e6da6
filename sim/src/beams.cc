#include "beams.h"

#include <dn/lidar/beam.h>
#include <dn/sim/random.h>

#include <string>

#include "active_effects.h"

namespace dn {
namespace {

/// Returns independent errors without their mean, which is an error of the whole scanner.
std::vector<double> DrawErrors(int count, double sigma, Random random) {
  std::vector<double> errors;
  double mean = 0.0;
  for (int k = 0; k < count; ++k) {
    errors.push_back(sigma * random.Normal());
    mean += errors.back() / count;
  }
  for (double& error : errors) error -= mean;
  return errors;
}

void DrawMissing(const std::string& name, std::uint64_t seed, BeamScenario* beams) {
  const auto draw = [&](const char* what, double sigma, std::vector<double>* errors) {
    if (!errors->empty()) return;
    *errors = DrawErrors(beams->count(), sigma, Random(seed, std::string(what) + name));
  };
  draw("beam angles ", beams->angle_sigma_rad, &beams->angle_error_rad);
  draw("beam ranges ", beams->range_sigma_m, &beams->range_error_m);
}

}  // namespace

Scenario WithBeamErrors(Scenario scenario, std::uint64_t seed) {
  DrawMissing(scenario.lidar.name, seed, &scenario.lidar.beams);
  for (LidarScenario& lidar : scenario.more_scanners) DrawMissing(lidar.name, seed, &lidar.beams);
  return scenario;
}

double TrueBeamAngle(const BeamScenario& beams, int beam) {
  const auto k = static_cast<std::size_t>(beam);
  return beams.angles_rad[k] + beams.angle_error_rad[k];
}

Eigen::Vector3d ReportedByBeam(const LidarScenario& lidar, int beam, const Eigen::Vector3d& u_s) {
  if (beam == kNoBeam) return u_s;
  const auto k = static_cast<std::size_t>(beam);
  const Eigen::Vector3d axis_s = lidar.scan_axis_s.normalized();
  const double longer = 1.0 + lidar.beams.range_error_m[k] / u_s.norm();
  return longer * TurnedTowardAxis(axis_s, -lidar.beams.angle_error_rad[k], u_s);
}

}  // namespace dn
