#include <dn/sim/dryden.h>
#include <dn/sim/scenario.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dn {
namespace {

constexpr double kMetresPerFoot = 0.3048;
constexpr double kLowestFt = 10.0, kLowFt = 1000.0, kHighFt = 2000.0, kHighScaleFt = 1750.0;
// Steps of the integration per e-fold of the frequency; the spectra are smooth.
constexpr double kStepsPerFold = 40.0;

double Square(double x) { return x * x; }

/// Returns L_u = L_v of low altitude, in feet.
double LowScaleFt(double height_ft) {
  return height_ft / std::pow(0.177 + 0.000823 * height_ft, 1.2);
}

}  // namespace

DrydenGusts DrydenGusts::At(double height_m, double airspeed_mps, double wingspan_m) {
  const double height_ft = std::max(kLowestFt, height_m / kMetresPerFoot);
  const double low_ft = std::min(height_ft, kLowFt);
  const double share = std::clamp((height_ft - kLowFt) / (kHighFt - kLowFt), 0.0, 1.0);
  const double scale_ft = LowScaleFt(low_ft) + share * (kHighScaleFt - LowScaleFt(low_ft));
  const double vertical_ft = low_ft + share * (kHighScaleFt - low_ft);
  return {airspeed_mps, wingspan_m, kMetresPerFoot * scale_ft, kMetresPerFoot * vertical_ft};
}

double DrydenGusts::Density(GustMotion motion, double f_hz) const {
  const double w_radps = 2.0 * std::numbers::pi * f_hz;
  const double a = w_radps / airspeed_mps;
  const double span = 1.0 / (1.0 + Square(4.0 * wingspan_m * a / std::numbers::pi));
  const double span_across = 1.0 / (1.0 + Square(3.0 * wingspan_m * a / std::numbers::pi));
  const auto across = [&](double length_m) {
    const double x = Square(length_m * a);
    return (1.0 + 3.0 * x) / Square(1.0 + x);
  };
  switch (motion) {
    case GustMotion::kRoll:
      return span / Square(w_radps);
    case GustMotion::kPitch:
      return across(vertical_scale_m) * span;
    case GustMotion::kHeading:
      return across(scale_m) * span_across;
    case GustMotion::kSpeed:
      return span / (1.0 + Square(scale_m * a));
    case GustMotion::kHeight:
      return across(vertical_scale_m) * span / Square(w_radps);
  }
  return 0.0;
}

double DrydenGusts::Power(GustMotion motion, double f_low_hz, double f_high_hz) const {
  const double folds = std::log(f_high_hz / f_low_hz);
  const int steps = std::max(1, static_cast<int>(std::ceil(kStepsPerFold * folds)));
  double sum = 0.0;
  for (int k = 0; k < steps; ++k) {
    const double f_hz = f_low_hz * std::exp(folds * (k + 0.5) / steps);
    sum += f_hz * Density(motion, f_hz);
  }
  return sum * folds / steps;
}

DrydenTurbulence::DrydenTurbulence(const TurbulenceScenario& turbulence, const DrydenGusts& gusts,
                                   double top_hz)
    : rms_{turbulence.roll_rad, turbulence.pitch_rad, turbulence.heading_rad, turbulence.speed_mps,
           turbulence.height_m},
      gusts_(gusts),
      top_hz_(top_hz) {}

double DrydenTurbulence::Rms(GustMotion motion, double f_low_hz, double f_high_hz) const {
  const double share =
      gusts_.Power(motion, f_low_hz, f_high_hz) / gusts_.Power(motion, LowestHz(motion), top_hz_);
  return rms_[static_cast<std::size_t>(motion)] * std::sqrt(share);
}

double DrydenTurbulence::LowestHz(GustMotion motion) {
  return motion == GustMotion::kSpeed || motion == GustMotion::kHeight ? 0.005 : 0.02;
}

}  // namespace dn
