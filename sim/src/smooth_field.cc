#include "smooth_field.h"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace dn {
namespace {

// The sum of this many waves is nearly normal.
constexpr int kWaves = 100;

}  // namespace

SmoothField::SmoothField(double length_m, Random* random) {
  for (std::vector<Wave>& axis : waves_) {
    for (int k = 0; k < kWaves; ++k) {
      const double x = random->Normal(), y = random->Normal();
      axis.push_back(
          {Eigen::Vector2d(x, y) / length_m, random->Uniform(0.0, 2.0 * std::numbers::pi)});
    }
  }
}

Eigen::Vector3d SmoothField::At(const Eigen::Vector2d& en_m) const {
  Eigen::Vector3d value = Eigen::Vector3d::Zero();
  for (std::size_t axis = 0; axis < waves_.size(); ++axis) {
    for (const Wave& wave : waves_[axis]) {
      value[static_cast<Eigen::Index>(axis)] += std::cos(wave.radpm.dot(en_m) + wave.phase_rad);
    }
  }
  return std::sqrt(2.0 / kWaves) * value;
}

}  // namespace dn
