#include <dn/sim/disturbance.h>
#include <dn/sim/random.h>
#include <dn/sim/scenario.h>

#include <cmath>
#include <numbers>

namespace dn {
namespace {

constexpr double kAttitudeLowHz = 0.02;
constexpr double kAttitudeHighHz = 1.0;
constexpr int kAttitudeWaves = 14;
constexpr double kPathLowHz = 0.005;
constexpr double kPathHighHz = 0.1;
constexpr int kPathWaves = 10;
// Limit for roll and for pitch, so that both together stay within 0.3 deg.
constexpr double kStabilisedRad = 0.3 / std::numbers::sqrt2 * std::numbers::pi / 180.0;

}  // namespace

SumOfSines::SumOfSines(double rms, double f_low_hz, double f_high_hz, int count, Random& random) {
  const double octave = std::log(f_high_hz / f_low_hz) / count;
  double power = 0.0;
  for (int i = 0; i < count; ++i) {
    const double f_hz = f_low_hz * std::exp(octave * (i + random.Uniform()));
    const double amplitude = 1.0 / std::sqrt(f_hz);
    power += 0.5 * amplitude * amplitude;
    waves_.push_back(
        {amplitude, 2.0 * std::numbers::pi * f_hz, random.Uniform(0.0, 2.0 * std::numbers::pi)});
  }
  for (Wave& wave : waves_) wave.amplitude *= rms / std::sqrt(power);
  if (rms == 0.0) waves_.clear();
}

SumOfSines::Sample SumOfSines::At(double t_s) const {
  Sample sum;
  for (const Wave& wave : waves_) {
    const double angle = wave.rate_radps * t_s + wave.phase_rad;
    const double s = wave.amplitude * std::sin(angle);
    sum.value += s;
    sum.first += wave.amplitude * wave.rate_radps * std::cos(angle);
    sum.second -= wave.rate_radps * wave.rate_radps * s;
  }
  return sum;
}

double SumOfSines::Bound() const {
  double bound = 0.0;
  for (const Wave& wave : waves_) bound += wave.amplitude;
  return bound;
}

void SumOfSines::LimitTo(double limit) {
  const double bound = Bound();
  if (bound <= limit) return;
  for (Wave& wave : waves_) wave.amplitude *= limit / bound;
}

void SumOfSines::Integrate() {
  for (Wave& wave : waves_) {
    wave.amplitude /= wave.rate_radps;
    wave.phase_rad -= 0.5 * std::numbers::pi;
  }
}

Disturbance MakeDisturbance(const TurbulenceScenario& turbulence, double mean_speed_mps,
                            bool stabilised, std::uint64_t seed) {
  const auto attitude = [&](double rms_rad, const char* stream) {
    Random random(seed, stream);
    return SumOfSines(rms_rad, kAttitudeLowHz, kAttitudeHighHz, kAttitudeWaves, random);
  };
  const auto along_path = [&](double rms, const char* stream) {
    Random random(seed, stream);
    return SumOfSines(rms, kPathLowHz, kPathHighHz, kPathWaves, random);
  };
  Disturbance d;
  d.roll_rad = attitude(turbulence.roll_rad, "turbulence roll");
  d.pitch_rad = attitude(turbulence.pitch_rad, "turbulence pitch");
  d.heading_rad = attitude(turbulence.heading_rad, "turbulence heading");
  d.height_m = along_path(turbulence.height_m, "turbulence height");
  d.lead_s = along_path(turbulence.speed_mps / mean_speed_mps, "turbulence speed");
  d.lead_s.Integrate();  // relative speed becomes time ahead
  if (stabilised) {
    d.roll_rad.LimitTo(kStabilisedRad);
    d.pitch_rad.LimitTo(kStabilisedRad);
  }
  return d;
}

}  // namespace dn
