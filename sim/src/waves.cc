#include "waves.h"

#include <cmath>
#include <numbers>

namespace dn {

double WaveHeight(const Eigen::Vector2d& en_m, double t_s) {
  constexpr double kRms_m = 0.03, kGravity_mps2 = 9.81;
  constexpr int kWavelengths = 5;
  double height_m = 0.0;
  for (int k = 0; k < kWavelengths; ++k) {
    const double wavelength_m = 6.0 * std::pow(0.63, k);
    const double azimuth = 0.6 + 0.9 * std::sin(2.4 * k);
    const double radpm = 2.0 * std::numbers::pi / wavelength_m;
    const double along_m = std::cos(azimuth) * en_m.x() + std::sin(azimuth) * en_m.y();
    height_m += std::sin(radpm * along_m - std::sqrt(kGravity_mps2 * radpm) * t_s + 1.7 * k);
  }
  return kRms_m * std::sqrt(2.0 / kWavelengths) * height_m;
}

}  // namespace dn
