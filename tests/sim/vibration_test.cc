#include <dn/rotation.h>
#include <dn/sim/simulate.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <string>

#include "sim/rates_are_derivatives.h"
#include "sim/small_scenario.h"

namespace dn::sim_test {

using Eigen::Vector3d;

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// Flies with a vibration, without noise and turbulence.
SimulatedFlight FlyShaken(const VibrationScenario& vibration, double rate_hz,
                          std::uint64_t seed = 1) {
  Scenario scenario = testing::SmallScenario();
  scenario.plan.turbulence = {};
  scenario.plan.vibration = vibration;
  scenario.plan.warm_up_s = 0.0;
  scenario.plan.lines.resize(1);
  scenario.pairs.count = 0;
  scenario.imu.rate_hz = rate_hz;
  SimulateOptions options;
  options.noise = false;
  options.seed = seed;
  return Simulate(scenario, options);
}

VibrationScenario OneLine(double frequency_hz, double accel_mps2, double angle_rad) {
  VibrationScenario v;
  v.lines.push_back(
      {frequency_hz, {Vector3d::Constant(accel_mps2), Vector3d::Constant(angle_rad)}, 1, 0.0});
  return v;
}

/// Returns the amplitude of a component of the frequency in the samples of the strip.
double Amplitude(const SimulatedFlight& flight, double frequency_hz,
                 const std::function<double(const ImuSample&)>& value) {
  std::complex<double> sum = 0.0;
  double weights = 0.0;
  const StripInterval& strip = flight.strips.front();
  for (const ImuSample& sample : flight.flight.imu->samples) {
    if (sample.t_s < strip.t0_s || sample.t_s > strip.t1_s) continue;
    const double share = (sample.t_s - strip.t0_s) / (strip.t1_s - strip.t0_s);
    const double weight = std::pow(std::sin(std::numbers::pi * share), 4);
    sum += weight * value(sample) * std::polar(1.0, -kTwoPi * frequency_hz * sample.t_s);
    weights += weight;
  }
  return 2.0 * std::abs(sum) / weights;
}

TEST(Vibration, LinesAppearInTheImuAsMeansOverItsIntervals) {
  constexpr double kAccel_mps2 = 0.5, kAngle_rad = 4e-6, kRelative = 0.01;
  for (const auto& [line_hz, seen_hz] : {std::pair(21.0, 21.0), {64.0, 36.0}, {130.0, 30.0}}) {
    SCOPED_TRACE(line_hz);
    const SimulatedFlight flight = FlyShaken(OneLine(line_hz, kAccel_mps2, kAngle_rad), 100.0);
    const double x = std::numbers::pi * line_hz / 100.0;
    const double mean = std::abs(std::sin(x) / x) * std::numbers::sqrt2;
    const double force = Amplitude(flight, seen_hz, [](const auto& s) { return s.f_b_mps2.z(); });
    EXPECT_NEAR(force, mean * kAccel_mps2, kRelative * mean * kAccel_mps2);
    const double rate = mean * kAngle_rad * kTwoPi * line_hz;
    EXPECT_NEAR(Amplitude(flight, seen_hz, [](const auto& s) { return s.w_ib_b_radps.x(); }), rate,
                kRelative * rate);
  }
}

TEST(Vibration, RatesAreDerivativesOfTheShakenPose) {
  const SimulatedFlight flight = FlyShaken(*VibrationPreset("helicopter"), 50.0);
  // Errors of fourth-order differences for 300 Hz, and rounding of the time and the position.
  ExpectRatesAreDerivatives(*flight.truth, 1.0 / 16384.0,
                            {.velocity_mps = 1e-4, .acceleration_mps2 = 1e-2, .rate_radps = 1e-6});
}

/// Strapdown integration of the samples of a span in the inertial frame that coincides with m at
/// its begin. Returns the differences from the true pose at its end.
struct StrapdownError {
  double position_m = 0.0, attitude_rad = 0.0;
};
StrapdownError Integrate(const SimulatedFlight& flight, double span_s) {
  const TruthTrajectory& truth = *flight.truth;
  const LocalFrame& frame = truth.frame();
  const std::vector<ImuSample>& samples = flight.flight.imu->samples;
  std::size_t k = 0;
  while (samples[k].t_s < flight.strips.front().t0_s) ++k;
  const double t0_s = samples[k].t_s;
  const MapPose begin = truth.Pose(t0_s);
  const Vector3d& w = frame.w_ie_m();
  const auto turned = [&](double t_s) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(w.norm() * (t_s - t0_s), w.normalized()));
  };
  Vector3d r = frame.r0_m() + begin.p_mb;
  Vector3d v = begin.v_m + w.cross(r);
  Eigen::Quaterniond q = begin.q_mb;
  for (++k; samples[k].t_s < t0_s + span_s; ++k) {
    const ImuSample& s = samples[k];
    const Vector3d middle = r + 0.5 * s.dt_s * v;
    const Eigen::Quaterniond q_im = turned(s.t_s - 0.5 * s.dt_s);
    const Eigen::Quaterniond half = Exp<double>(0.5 * s.dt_s * s.w_ib_b_radps);
    const Vector3d a =
        q * half * s.f_b_mps2 + q_im * frame.Gravitation(q_im.conjugate() * middle - frame.r0_m());
    r += s.dt_s * v + 0.5 * s.dt_s * s.dt_s * a;
    v += s.dt_s * a;
    q = (q * half * half).normalized();
  }
  const double end_s = samples[k - 1].t_s;
  const MapPose end = truth.Pose(end_s);
  const Eigen::Quaterniond q_mb = turned(end_s).conjugate() * q;
  const Vector3d p_m = turned(end_s).conjugate() * r - frame.r0_m();
  return {(p_m - end.p_mb).norm(), Log<double>(q_mb.conjugate() * end.q_mb).norm()};
}

TEST(Vibration, IntegratedRecordFollowsTheTruePose) {
  constexpr double kSpan_s = 15.0;
  const StrapdownError calm = Integrate(FlyShaken({}, 200.0), kSpan_s);
  // A line moves different axes coherently. A sampled record loses the mean of their products.
  for (const std::string& name : VibrationPresetNames()) {
    SCOPED_TRACE(name);
    const StrapdownError shaken = Integrate(FlyShaken(*VibrationPreset(name), 200.0), kSpan_s);
    EXPECT_LT(shaken.attitude_rad, calm.attitude_rad + 5e-6);
    EXPECT_LT(shaken.position_m, calm.position_m + 0.01);
  }
}

TEST(Vibration, AntennaAndScannerMoveWithTheBody) {
  constexpr double kFrequency_hz = 5.0, kAccel_mps2 = 2.0, kAngle_rad = 1e-3;
  const SimulatedFlight shaken = FlyShaken(OneLine(kFrequency_hz, kAccel_mps2, kAngle_rad), 50.0);
  const SimulatedFlight calm = FlyShaken({}, 50.0);
  double shift2 = 0.0, turn2 = 0.0;
  int count = 0;
  for (double t_s = calm.truth->t_begin_s() + 1.0; t_s < calm.truth->t_end_s() - 1.0;
       t_s += 0.0137, ++count) {
    const MapPose a = shaken.truth->Pose(t_s), b = calm.truth->Pose(t_s);
    shift2 += (a.p_mb - b.p_mb).squaredNorm();
    turn2 += Log<double>(b.q_mb.conjugate() * a.q_mb).squaredNorm();
  }
  const double rate_radps = kTwoPi * kFrequency_hz;
  const double shift_m = std::sqrt(3.0) * kAccel_mps2 / (rate_radps * rate_radps);
  EXPECT_NEAR(std::sqrt(shift2 / count), shift_m, 0.02 * shift_m);
  EXPECT_NEAR(std::sqrt(turn2 / count), std::sqrt(3.0) * kAngle_rad, 0.02 * kAngle_rad);
  for (const MapGnssEpoch& epoch : shaken.flight.gnss->epochs) {
    const MapPose pose = shaken.truth->Pose(epoch.t_s);
    const Vector3d antenna_m = pose.p_mb + pose.q_mb * shaken.gnss_lever_arm_b_m;
    EXPECT_LT((epoch.p_m - antenna_m).norm(), 1e-9);
  }
}

TEST(Vibration, SpectrumOfAResonanceAndABandLiesWhereTheyAre) {
  VibrationScenario v;
  v.resonances = {{20.0, 0.05, {Vector3d::Constant(1.0), Vector3d::Zero()}}};
  v.broadband = {{40.0, 60.0, {Vector3d::Constant(1.0), Vector3d::Zero()}}};
  const SimulatedFlight flight = FlyShaken(v, 400.0);
  const auto power = [&](double low_hz, double high_hz) {
    double sum = 0.0;
    for (double f_hz = low_hz; f_hz < high_hz; f_hz += 0.03) {
      sum += std::pow(Amplitude(flight, f_hz, [](const auto& s) { return s.f_b_mps2.y(); }), 2);
    }
    return sum;
  };
  const double resonance = power(17.0, 23.0), band = power(40.0, 60.0);
  EXPECT_NEAR(resonance / band, 0.8, 0.25);  // 80 % of a resonance lie within 3 Hz of its peak
  EXPECT_LT(power(28.0, 38.0), 0.1 * band);
  EXPECT_LT(power(63.0, 90.0), 0.02 * band);
}

TEST(Vibration, DependsOnTheSeedAlone) {
  const VibrationScenario v = *VibrationPreset("multirotor");
  const SimulatedFlight a = FlyShaken(v, 20.0), b = FlyShaken(v, 20.0), c = FlyShaken(v, 20.0, 2);
  bool differs = false;
  for (std::size_t k = 0; k < a.flight.imu->samples.size(); ++k) {
    EXPECT_EQ(a.flight.imu->samples[k].f_b_mps2, b.flight.imu->samples[k].f_b_mps2);
    EXPECT_EQ(a.flight.imu->samples[k].w_ib_b_radps, b.flight.imu->samples[k].w_ib_b_radps);
    differs = differs || a.flight.imu->samples[k].f_b_mps2 != c.flight.imu->samples[k].f_b_mps2;
  }
  EXPECT_TRUE(differs);
}

}  // namespace dn::sim_test
