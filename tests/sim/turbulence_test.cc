#include <dn/sim/simulate.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <string>
#include <vector>

#include "sim/rates_are_derivatives.h"
#include "sim/small_scenario.h"

namespace dn::sim_test {

constexpr double kRoll_rad = 0.02, kHeight_m = 2.0, kSpeed_mps = 1.0, kSpan_m = 5.0;
constexpr double kGustRate_hz = 100.0;

/// Flies straight lines in Dryden's turbulence, without noise. The lines are 800 m above ground.
SimulatedFlight FlyInGusts() {
  Scenario scenario = testing::SmallScenario();
  scenario.plan.turbulence = {.roll_rad = kRoll_rad,
                              .pitch_rad = kRoll_rad,
                              .heading_rad = kRoll_rad,
                              .speed_mps = kSpeed_mps,
                              .height_m = kHeight_m,
                              .spectrum = TurbulenceSpectrum::kDryden,
                              .wingspan_m = kSpan_m};
  scenario.plan.warm_up_s = 0.0;
  scenario.plan.lines.resize(1);
  scenario.plan.lines[0].end_en_m.x() = 1500.0;
  scenario.terrain.base_m = -600.0;
  scenario.pairs.count = 0;
  scenario.imu.rate_hz = kGustRate_hz;
  SimulateOptions options;
  options.noise = false;
  return Simulate(scenario, options);
}

/// Returns the power of a signal of the true motion between two frequencies, on the strip.
double BandPower(const SimulatedFlight& flight, double low_hz, double high_hz,
                 const std::function<double(const TruthState&)>& signal) {
  constexpr double kSample_s = 1.0 / 512.0;
  const StripInterval& strip = flight.strips.front();
  const double span_s = strip.t1_s - strip.t0_s;
  std::vector<double> weighted;
  double weights = 0.0;
  for (double t_s = strip.t0_s; t_s < strip.t1_s; t_s += kSample_s) {
    const double weight = std::pow(std::sin(std::numbers::pi * (t_s - strip.t0_s) / span_s), 4);
    weighted.push_back(weight * signal(flight.truth->State(t_s)));
    weights += weight * weight;
  }
  double power = 0.0;
  for (double f_hz = low_hz; f_hz < high_hz; f_hz += 1.0 / span_s) {
    const std::complex<double> step = std::polar(1.0, -2.0 * std::numbers::pi * f_hz * kSample_s);
    std::complex<double> turn = 1.0, sum = 0.0;
    for (const double x : weighted) {
      sum += x * turn;
      turn *= step;
    }
    power += 2.0 * std::norm(sum);
  }
  return power * kSample_s / (span_s * weights);
}

/// A motion of the Dryden model, and the signal that shows it: a derivative of order 1 or 2.
struct SeenMotion {
  std::string name;
  GustMotion motion;
  int order;
  std::function<double(const TruthState&)> signal;
};

TEST(Turbulence, HasTheSpectraOfDrydenBeyondTheNyquistFrequency) {
  const SimulatedFlight flight = FlyInGusts();
  const DrydenTurbulence theory(flight.scenario.plan.turbulence,
                                DrydenGusts::At(800.0, 45.0, kSpan_m), kGustRate_hz);
  const std::vector<SeenMotion> motions{
      {"roll", GustMotion::kRoll, 1, [](const TruthState& s) { return s.w_mb_b.x(); }},
      {"pitch", GustMotion::kPitch, 1, [](const TruthState& s) { return s.w_mb_b.y(); }},
      {"speed", GustMotion::kSpeed, 1, [](const TruthState& s) { return s.a_m.x(); }},
      {"height", GustMotion::kHeight, 2, [](const TruthState& s) { return s.a_m.z(); }}};
  for (const SeenMotion& seen : motions) {
    for (const double low_hz : {4.0, 12.0, 36.0}) {
      SCOPED_TRACE(seen.name + " from " + std::to_string(low_hz) + " Hz");
      constexpr int kParts = 200;
      const double high_hz = low_hz < 30.0 ? 2.0 * low_hz : 98.0;
      double expected = 0.0;
      for (int k = 0; k < kParts; ++k) {
        const double f0_hz = low_hz + (high_hz - low_hz) * k / kParts,
                     f1_hz = low_hz + (high_hz - low_hz) * (k + 1) / kParts;
        expected += std::pow(theory.Rms(seen.motion, f0_hz, f1_hz), 2) *
                    std::pow(std::numbers::pi * (f0_hz + f1_hz), 2 * seen.order);
      }
      // The wander of the tones of a band of an octave moves some of their power across its edges.
      EXPECT_NEAR(BandPower(flight, low_hz, high_hz, seen.signal) / expected, 1.0, 0.25);
    }
  }
}

TEST(Turbulence, RootMeanSquaresIncludeAllFrequencies) {
  const DrydenTurbulence gusts({.roll_rad = kRoll_rad, .spectrum = TurbulenceSpectrum::kDryden},
                               DrydenGusts::At(800.0, 45.0, kSpan_m), kGustRate_hz);
  const double slow_rad = gusts.Rms(GustMotion::kRoll, 0.02, 1.0),
               fast_rad = gusts.Rms(GustMotion::kRoll, 1.0, kGustRate_hz);
  EXPECT_NEAR(std::hypot(slow_rad, fast_rad), kRoll_rad, 1e-3 * kRoll_rad);
  EXPECT_EQ(gusts.Rms(GustMotion::kPitch, 0.02, 1.0), 0.0);
}

// Hand-computed from MIL-F-8785C: 1750 ft above 2000 ft, h/(0.177 + 0.000823 h)^1.2 at 500 ft.
TEST(Turbulence, ScaleLengthsDependOnTheHeight) {
  const DrydenGusts high = DrydenGusts::At(800.0, 45.0, kSpan_m);
  EXPECT_NEAR(high.scale_m, 533.4, 1e-9);
  EXPECT_NEAR(high.vertical_scale_m, 533.4, 1e-9);
  const DrydenGusts low = DrydenGusts::At(152.4, 45.0, kSpan_m);
  EXPECT_NEAR(low.vertical_scale_m, 152.4, 1e-9);
  EXPECT_NEAR(low.scale_m, 152.4 / std::pow(0.5885, 1.2), 1e-6);
  EXPECT_NEAR(DrydenGusts::At(304.8, 45.0, kSpan_m).scale_m, 304.8, 1e-6);  // 0.177 + 0.823 = 1
}

TEST(Turbulence, RatesAreDerivativesOfThePose) {
  const SimulatedFlight flight = FlyInGusts();
  ExpectRatesAreDerivatives(*flight.truth, 1.0 / 16384.0,
                            {.velocity_mps = 1e-4, .acceleration_mps2 = 1e-2, .rate_radps = 1e-6});
}

}  // namespace dn::sim_test
