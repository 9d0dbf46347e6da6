#include "low_pass.h"

#include <dn/error.h>

#include <cmath>
#include <numbers>

namespace dn {
namespace {

// 2 cos of the angles of the poles: the damping of both sections of order two.
constexpr std::array<double, 2> kDamping{0.7653668647301796, 1.8477590650225735};

}  // namespace

LowPass::LowPass(double cut_off_hz, double rate_hz, const Vector& first) {
  if (!(cut_off_hz > 0.0 && cut_off_hz < 0.5 * rate_hz)) {
    throw InvalidInput("a filter needs a cut-off frequency between 0 and half the sampling rate");
  }
  const double k = std::tan(std::numbers::pi * cut_off_hz / rate_hz), k2 = k * k;
  for (std::size_t i = 0; i < sections_.size(); ++i) {
    const double norm = 1.0 / (1.0 + kDamping[i] * k + k2);
    Section& section = sections_[i];
    section.b0 = k2 * norm;
    section.a1 = 2.0 * (k2 - 1.0) * norm;
    section.a2 = (1.0 - kDamping[i] * k + k2) * norm;
    // The state that a constant input leaves.
    section.first = (1.0 - section.b0) * first;
    section.second = (section.b0 - section.a2) * first;
  }
}

LowPass::Vector LowPass::Next(const Vector& sample) {
  Vector x = sample;
  for (Section& s : sections_) {
    const Vector y = s.b0 * x + s.first;
    s.first = 2.0 * s.b0 * x - s.a1 * y + s.second;
    s.second = s.b0 * x - s.a2 * y;
    x = y;
  }
  return x;
}

double LowPass::Delay(double cut_off_hz, double rate_hz) {
  return (kDamping[0] + kDamping[1]) /
         (2.0 * rate_hz * std::tan(std::numbers::pi * cut_off_hz / rate_hz));
}

}  // namespace dn
