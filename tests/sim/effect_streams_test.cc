#include <dn/effects/effect_table.h>
#include <dn/sim/simulate.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sim/small_scenario.h"

namespace dn::sim_test {

SimulatedFlight With(const std::string& effects) {
  return Simulate(testing::SmallScenario("effects: [" + effects + "]\n"), {});
}

bool Same(const ImuSample& a, const ImuSample& b) {
  return a.t_s == b.t_s && a.w_ib_b_radps == b.w_ib_b_radps && a.f_b_mps2 == b.f_b_mps2;
}

bool Same(const MapGnssEpoch& a, const MapGnssEpoch& b) { return a.t_s == b.t_s && a.p_m == b.p_m; }

bool Same(const LidarPair& a, const LidarPair& b) {
  return a.t_i_s == b.t_i_s && a.t_j_s == b.t_j_s && a.u_i_s == b.u_i_s && a.u_j_s == b.u_j_s;
}

template <class T>
bool Same(const std::vector<T>& a, const std::vector<T>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!Same(a[i], b[i])) return false;
  }
  return true;
}

bool SameImu(const SimulatedFlight& a, const SimulatedFlight& b) {
  return Same(a.flight.imu->samples, b.flight.imu->samples);
}
bool SameGnss(const SimulatedFlight& a, const SimulatedFlight& b) {
  return Same(a.flight.gnss->epochs, b.flight.gnss->epochs);
}
bool SamePairs(const SimulatedFlight& a, const SimulatedFlight& b) {
  return Same(a.flight.pairs->pairs, b.flight.pairs->pairs);
}

const std::string kGnss = "{effect: gnss_correlated_noise, value: [0.1, 0.1, 0.1, 9]}";
const std::string kGross = "{effect: gnss_outliers, value: [0.1, 5]}";
const std::string kBias = "{effect: gyro_bias_process, value: [5, 20]}";
const std::string kShake = "{effect: imu_vibration, value: [0.1, 0.3], window_s: [381050, 381150]}";
const std::string kWrong = "{effect: p2p_outliers, value: [0.2, 5]}";

TEST(EffectStreams, AnUnrelatedEntryOrAnotherOrderChangesNoNumber) {
  const SimulatedFlight plain =
      With(kGnss + "," + kGross + "," + kBias + "," + kShake + "," + kWrong);
  const SimulatedFlight other =
      With("{effect: gnss_time_offset, value: 0}, {effect: accel_bias_process, value: [0, 7]}," +
           kWrong + ", {effect: boresight_drift, value: [0, 0, 0]}," + kShake + "," + kBias + "," +
           kGross +
           ", {effect: gravity_tilt, value: [0, 0]}, {effect: lidar_scan_cone, value: 0}," + kGnss);
  EXPECT_TRUE(SameImu(plain, other));
  EXPECT_TRUE(SameGnss(plain, other));
  EXPECT_TRUE(SamePairs(plain, other));
}

TEST(EffectStreams, OneSensorsEffectsLeaveTheOthersAlone) {
  const SimulatedFlight clean = With("");
  const SimulatedFlight gnss = With(kGnss + "," + kGross);
  const SimulatedFlight imu = With(kBias + "," + kShake);
  const SimulatedFlight pairs = With(kWrong);
  EXPECT_TRUE(SameImu(clean, gnss) && !SameGnss(clean, gnss) && SamePairs(clean, gnss));
  EXPECT_TRUE(!SameImu(clean, imu) && SameGnss(clean, imu) && SamePairs(clean, imu));
  EXPECT_TRUE(SameImu(clean, pairs) && SameGnss(clean, pairs) && !SamePairs(clean, pairs));
}

TEST(EffectStreams, EntriesOfOneNameAreIndependent) {
  const SimulatedFlight one = With(kBias);
  const SimulatedFlight two = With(kBias + "," + kBias);
  const SimulatedFlight clean = With("");
  double twice = 0.0;
  for (std::size_t k = 0; k < clean.gyro_bias_radps.size(); ++k) {
    const Eigen::Vector3d first = one.gyro_bias_radps[k] - clean.gyro_bias_radps[k];
    const Eigen::Vector3d both = two.gyro_bias_radps[k] - clean.gyro_bias_radps[k];
    twice = std::max(twice, (both - 2.0 * first).norm());
  }
  EXPECT_GT(twice, 1e-6);
}

/// Returns an entry with every component at ten times its typical size, limited to the allowed
/// range.
std::string LargeEntry(const EffectSpec& effect) {
  std::string value;
  for (const EffectComponent& part : effect.components) {
    const double large = std::min(10.0 * part.typical, part.highest);
    value += (value.empty() ? "" : ", ") + std::to_string(large);
  }
  std::string text = "{effect: " + effect.name;
  if (!value.empty()) text += ", value: [" + value + "]";
  if (effect.timing == EffectTiming::kWindow) text += ", window_s: [381050, 381060]";
  if (effect.timing == EffectTiming::kStart) text += ", t0_s: 381150";
  return text + "}";
}

TEST(EffectStreams, EveryEffectOfTheTableIsSimulated) {
  const SimulatedFlight clean = With("");
  for (const EffectSpec& effect : EffectTable()) {
    const SimulatedFlight with = With(LargeEntry(effect));
    const bool imu = !SameImu(clean, with);
    const bool gnss = !SameGnss(clean, with);
    const bool pairs = !SamePairs(clean, with);
    switch (effect.sensor) {
      case EffectSensor::kImu:
      case EffectSensor::kGyro:
      case EffectSensor::kAccel:
        EXPECT_TRUE(imu && !gnss && !pairs) << effect.name;
        break;
      case EffectSensor::kGnss:
        EXPECT_TRUE(!imu && gnss && !pairs) << effect.name;
        break;
      case EffectSensor::kLidar:
      case EffectSensor::kPairs:
        EXPECT_TRUE(!imu && !gnss && pairs) << effect.name;
        break;
      case EffectSensor::kTrajectory:
        EXPECT_TRUE(!imu && !gnss && !pairs && with.flight.trajectory) << effect.name;
        break;
    }
  }
}

}  // namespace dn::sim_test
