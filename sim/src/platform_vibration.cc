#include "platform_vibration.h"

#include <dn/sim/random.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "sine_table.h"

namespace dn {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
// Frequencies of the slow changes of an engine's speed.
constexpr double kWanderLowHz = 0.02, kWanderHighHz = 0.3;
constexpr int kWanderWaves = 3;
// The highest frequency allows for wander of this many times its rms.
constexpr double kWanderSigmas = 3.0;
constexpr int kResonanceTones = 24, kBandTones = 40;
// Number of different wanders of the tones of a continuum. The wander is slower by this factor than
// the width of the interval of a tone.
constexpr std::size_t kContinuumWanders = 2;
constexpr double kSlowness = 3.0;
// Frequencies of a resonance relative to its peak, as far as it is simulated.
constexpr double kResonanceLow = 0.25, kResonanceHigh = 3.0;
constexpr int kResonanceGrid = 4000;
// Fast turbulence has six tones per octave.
constexpr double kTurbulenceBand = 2.0;
constexpr int kTurbulenceTones = 6;

/// Returns count + 1 frequencies that divide the power of a resonance into equal parts.
std::vector<double> EqualPowerEdges(const VibrationResonance& resonance, int count) {
  const double step = (kResonanceHigh - kResonanceLow) / kResonanceGrid;
  std::vector<double> power{0.0};
  for (int i = 0; i < kResonanceGrid; ++i) {
    const double ratio = kResonanceLow + (i + 0.5) * step;
    const double stiffness = 1.0 - ratio * ratio, damping = 2.0 * resonance.damping * ratio;
    power.push_back(power.back() + 1.0 / (stiffness * stiffness + damping * damping));
  }
  std::vector<double> edges_hz;
  for (int k = 0; k <= count; ++k) {
    const double wanted = power.back() * k / count;
    const auto at = std::lower_bound(power.begin(), power.end(), wanted) - power.begin();
    edges_hz.push_back(resonance.frequency_hz * (kResonanceLow + static_cast<double>(at) * step));
  }
  return edges_hz;
}

std::vector<double> EqualEdges(const VibrationBand& band, int count) {
  std::vector<double> edges_hz;
  for (int k = 0; k <= count; ++k) {
    edges_hz.push_back(band.low_hz + (band.high_hz - band.low_hz) * k / count);
  }
  return edges_hz;
}

double MiddleHz(const std::vector<double>& edges_hz, std::size_t k) {
  return 0.5 * (edges_hz[k] + edges_hz[k + 1]);
}

/// Returns the motion by gusts between two frequencies. The body moves along its path with the
/// speed, and downward with the height.
VibrationLevel GustLevel(const DrydenTurbulence& turbulence, bool stabilised, double low_hz,
                         double high_hz) {
  const double rate_radps = kTwoPi * 0.5 * (low_hz + high_hz);
  const auto rms = [&](GustMotion motion) { return turbulence.Rms(motion, low_hz, high_hz); };
  const double level = stabilised ? 0.0 : 1.0;
  return {
      {rate_radps * rms(GustMotion::kSpeed), 0.0,
       rate_radps * rate_radps * rms(GustMotion::kHeight)},
      {level * rms(GustMotion::kRoll), level * rms(GustMotion::kPitch), rms(GustMotion::kHeading)}};
}

}  // namespace

PlatformVibration::PlatformVibration(const VibrationScenario& scenario, std::uint64_t seed) {
  Random random(seed, "platform vibration");
  for (const VibrationLine& line : scenario.lines) AddLine(line, random);
  for (const VibrationResonance& resonance : scenario.resonances) {
    AddContinuum(EqualPowerEdges(resonance, kResonanceTones), resonance.level, random);
  }
  for (const VibrationBand& band : scenario.broadband) {
    AddContinuum(EqualEdges(band, kBandTones), band.level, random);
  }
}

std::size_t PlatformVibration::AddWander(double rms_radps, double low_hz, double high_hz,
                                         Random& random) {
  SumOfSines wander(rms_radps, low_hz, high_hz, kWanderWaves, random);
  wander.Integrate();
  wander_rad_.push_back(std::move(wander));
  return wander_rad_.size() - 1;
}

void PlatformVibration::AddTone(double frequency_hz, const VibrationLevel& level,
                                std::size_t wander, double wander_share, Random& random) {
  const double rate_radps = kTwoPi * frequency_hz;
  Vector amplitude;
  amplitude << level.accel_mps2 / (rate_radps * rate_radps), level.angle_rad;
  amplitude *= std::numbers::sqrt2;
  Tone tone{rate_radps, wander, wander_share, {}, {}};
  for (Eigen::Index k = 0; k < amplitude.size(); ++k) {
    const double phase_rad = random.Uniform(0.0, kTwoPi);
    tone.cosine[k] = amplitude[k] * std::cos(phase_rad);
    tone.sine[k] = amplitude[k] * std::sin(phase_rad);
  }
  tones_.push_back(tone);
}

void PlatformVibration::AddLine(const VibrationLine& line, Random& random) {
  const std::size_t wander =
      AddWander(kTwoPi * line.wander * line.frequency_hz, kWanderLowHz, kWanderHighHz, random);
  for (int n = 1; n <= line.harmonics; ++n) {
    const VibrationLevel level{line.level.accel_mps2 / n, line.level.angle_rad / (n * n * n)};
    AddTone(n * line.frequency_hz, level, wander, n, random);
  }
  highest_hz_ = std::max(highest_hz_,
                         line.harmonics * line.frequency_hz * (1.0 + kWanderSigmas * line.wander));
}

void PlatformVibration::AddContinuum(const std::vector<double>& edges_hz,
                                     const VibrationLevel& level, Random& random) {
  const std::size_t count = edges_hz.size() - 1;
  // The angular accelerations of all tones are equal.
  double angle_power = 0.0;
  for (std::size_t k = 0; k < count; ++k) angle_power += std::pow(MiddleHz(edges_hz, k), -4);
  std::vector<VibrationLevel> levels;
  for (std::size_t k = 0; k < count; ++k) {
    levels.push_back(
        {level.accel_mps2 / std::sqrt(static_cast<double>(count)),
         level.angle_rad * std::pow(MiddleHz(edges_hz, k), -2) / std::sqrt(angle_power)});
  }
  AddTones(edges_hz, levels, random);
}

void PlatformVibration::AddTones(const std::vector<double>& edges_hz,
                                 const std::vector<VibrationLevel>& levels, Random& random) {
  const double half_width_hz =
      0.5 * (edges_hz.back() - edges_hz.front()) / static_cast<double>(levels.size());
  std::vector<std::size_t> wanders;
  for (std::size_t k = 0; k < kContinuumWanders; ++k) {
    const double slow_hz = half_width_hz / kSlowness;
    wanders.push_back(AddWander(kTwoPi * half_width_hz, 0.5 * slow_hz, slow_hz, random));
  }
  for (std::size_t k = 0; k < levels.size(); ++k) {
    const double half_hz = 0.5 * (edges_hz[k + 1] - edges_hz[k]);
    AddTone(MiddleHz(edges_hz, k), levels[k], wanders[k % kContinuumWanders],
            half_hz / half_width_hz / std::numbers::sqrt2, random);
  }
  highest_hz_ = std::max(highest_hz_, edges_hz.back());
}

void PlatformVibration::AddTurbulence(const DrydenTurbulence& turbulence, bool stabilised,
                                      std::uint64_t seed) {
  Random random(seed, "fast turbulence");
  double low_hz = DrydenTurbulence::kSplit_hz;
  while (low_hz < turbulence.top_hz()) {
    const double high_hz = std::min(kTurbulenceBand * low_hz, turbulence.top_hz());
    std::vector<double> edges_hz;
    for (int k = 0; k <= kTurbulenceTones; ++k) {
      edges_hz.push_back(low_hz + (high_hz - low_hz) * k / kTurbulenceTones);
    }
    std::vector<VibrationLevel> levels;
    for (int k = 0; k < kTurbulenceTones; ++k) {
      levels.push_back(GustLevel(turbulence, stabilised, edges_hz[k], edges_hz[k + 1]));
    }
    AddTones(edges_hz, levels, random);
    low_hz = high_hz;
  }
}

PlatformVibration::Sample PlatformVibration::At(double t_s) const {
  std::vector<SumOfSines::Sample> wander;
  wander.reserve(wander_rad_.size());
  for (const SumOfSines& sum : wander_rad_) wander.push_back(sum.At(t_s));
  static const SineTable table;
  Vector value = Vector::Zero(), first = Vector::Zero();
  Eigen::Vector3d shift_accel = Eigen::Vector3d::Zero();
  for (const Tone& tone : tones_) {
    const SumOfSines::Sample& slow = wander[tone.wander];
    const double rate_radps = tone.rate_radps + tone.wander_share * slow.first;
    const auto [cosine, sine] = table.At(tone.rate_radps * t_s + tone.wander_share * slow.value);
    const Vector x = cosine * tone.cosine + sine * tone.sine;
    const Vector per_rad = cosine * tone.sine - sine * tone.cosine;
    value += x;
    first += rate_radps * per_rad;
    shift_accel +=
        tone.wander_share * slow.second * per_rad.head<3>() - rate_radps * rate_radps * x.head<3>();
  }
  return {value.head<3>(), first.head<3>(), shift_accel, value.tail<3>(), first.tail<3>()};
}

}  // namespace dn
