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
constexpr int kGustWaves = 24;
// Limit for roll and for pitch, so that both together stay within 0.3 deg.
constexpr double kStabilisedRad = 0.3 / std::numbers::sqrt2 * std::numbers::pi / 180.0;

}  // namespace

double SumOfSines::FallingAmplitude(double f_hz) { return 1.0 / std::sqrt(f_hz); }

SumOfSines::SumOfSines(double rms, double f_low_hz, double f_high_hz, int count, Random& random,
                       const std::function<double(double f_hz)>& relative_amplitude) {
  const double octave = std::log(f_high_hz / f_low_hz) / count;
  double power = 0.0;
  for (int i = 0; i < count; ++i) {
    const double f_hz = f_low_hz * std::exp(octave * (i + random.Uniform()));
    const double amplitude = relative_amplitude(f_hz);
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

namespace {

/// Draws the motions of a disturbance, each from its own stream of random numbers.
class Waves {
 public:
  Waves(std::uint64_t seed, const DrydenTurbulence* dryden) : seed_(seed), dryden_(dryden) {}

  SumOfSines Attitude(double rms_rad, GustMotion motion, const char* stream) const {
    Random random(seed_, stream);
    if (dryden_ != nullptr) return Gusts(motion, &random);
    return SumOfSines(rms_rad, kAttitudeLowHz, kAttitudeHighHz, kAttitudeWaves, random);
  }

  /// Returns a motion along the path or upward in a unit.
  SumOfSines AlongPath(double rms, GustMotion motion, const char* stream, double unit = 1.0) const {
    Random random(seed_, stream);
    if (dryden_ != nullptr) return Gusts(motion, &random, unit);
    return SumOfSines(rms / unit, kPathLowHz, kPathHighHz, kPathWaves, random);
  }

 private:
  SumOfSines Gusts(GustMotion motion, Random* random, double unit = 1.0) const {
    const double low_hz = DrydenTurbulence::LowestHz(motion), high_hz = DrydenTurbulence::kSplit_hz;
    return SumOfSines(dryden_->Rms(motion, low_hz, high_hz) / unit, low_hz, high_hz, kGustWaves,
                      *random, [&](double f_hz) {
                        // The waves are evenly spaced on a logarithmic scale.
                        return std::sqrt(f_hz * dryden_->gusts().Density(motion, f_hz));
                      });
  }

  std::uint64_t seed_;
  const DrydenTurbulence* dryden_;
};

}  // namespace

Disturbance MakeDisturbance(const TurbulenceScenario& turbulence, double mean_speed_mps,
                            bool stabilised, std::uint64_t seed, const DrydenTurbulence* dryden) {
  const Waves waves(seed, dryden);
  Disturbance d;
  d.roll_rad = waves.Attitude(turbulence.roll_rad, GustMotion::kRoll, "turbulence roll");
  d.pitch_rad = waves.Attitude(turbulence.pitch_rad, GustMotion::kPitch, "turbulence pitch");
  d.heading_rad =
      waves.Attitude(turbulence.heading_rad, GustMotion::kHeading, "turbulence heading");
  d.height_m = waves.AlongPath(turbulence.height_m, GustMotion::kHeight, "turbulence height");
  d.lead_s =
      waves.AlongPath(turbulence.speed_mps, GustMotion::kSpeed, "turbulence speed", mean_speed_mps);
  d.lead_s.Integrate();  // relative speed becomes time ahead
  if (stabilised) {
    d.roll_rad.LimitTo(kStabilisedRad);
    d.pitch_rad.LimitTo(kStabilisedRad);
  }
  return d;
}

}  // namespace dn
