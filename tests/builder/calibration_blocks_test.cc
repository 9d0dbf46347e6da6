#include <dn/builder/calibration_blocks.h>
#include <dn/effects/effect_table.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include "testing/short_flights.h"

namespace dn::builder_test {

/// Returns a flight that estimates effects on each sensor, in another order than that of the
/// corrections.
Flight FlightWithEffects() {
  Flight flight = Simulate(testing::DroneScenario(), {}).flight;
  for (const char* name : {"lidar_range_scale", "gnss_time_offset", "gyro_scale_factor"}) {
    flight.config.estimate.push_back({.unknown = name});
  }
  return flight;
}

TEST(CalibrationBlocks, StateIsThatOfTheBlocks) {
  const Flight flight = FlightWithEffects();
  CalibrationState initial = AssumedCalibration(flight);
  initial.lidar_time_offset_s = 0.002;
  initial.effects.back().value[0] = 3e-4;
  Network net;
  const CalibrationBlocks blocks(flight, initial, &net);
  const Eigen::Vector3d lever_arm_m(0.1, 0.2, 0.3);
  const Eigen::Quaterniond q_boresight = Exp(Eigen::Vector3d(0.01, -0.02, 0.03));
  net.SetValue(blocks.gnss_lever_arm(), lever_arm_m);
  net.SetValue(blocks.boresight(), q_boresight);

  const CalibrationState state = blocks.State();
  EXPECT_EQ(state.gnss_lever_arm_b_m, lever_arm_m);
  EXPECT_LE(state.q_boresight.angularDistance(q_boresight), 1e-15);
  EXPECT_EQ(state.lidar_lever_arm_b_m, initial.lidar_lever_arm_b_m);
  EXPECT_EQ(state.lidar_time_offset_s, 0.002);
  ASSERT_EQ(state.effects.size(), initial.effects.size());
  for (std::size_t k = 0; k < state.effects.size(); ++k) {
    EXPECT_EQ(state.effects[k].name, initial.effects[k].name);
    EXPECT_EQ(state.effects[k].value, initial.effects[k].value);
  }
}

TEST(CalibrationBlocks, EffectsOfASensorHaveTheirBlocks) {
  const Flight flight = FlightWithEffects();
  const CalibrationState initial = AssumedCalibration(flight);
  Network net;
  const CalibrationBlocks blocks(flight, initial, &net);
  EXPECT_EQ(blocks.EffectIds(GnssEffectIndices(initial)),
            std::vector<BlockId>{net.Find("gnss_time_offset")});
  EXPECT_EQ(blocks.EffectIds(InertialEffectIndices(initial)),
            std::vector<BlockId>{net.Find("gyro_scale_factor")});
  const std::vector<BlockId> pair{net.Find("lidar_range_scale"), net.Find("gyro_scale_factor")};
  EXPECT_EQ(blocks.EffectIds(PairEffectIndices(initial)), pair);
}

TEST(CalibrationBlocks, OnlyClocksMoveTheEpochsOfTheLaser) {
  Flight flight = FlightWithEffects();
  const auto moves = [&] {
    Network net;
    return CalibrationBlocks(flight, AssumedCalibration(flight), &net).MovesLidarEpochs();
  };
  EXPECT_FALSE(moves());
  for (const char* name : {"lidar_time_offset", "lidar_time_drift"}) {
    flight.config.estimate.push_back({.unknown = name});
    EXPECT_TRUE(moves()) << name;
    flight.config.estimate.pop_back();
  }
}

}  // namespace dn::builder_test
