#include <dn/builder/beam_unknowns.h>
#include <dn/builder/calibration_blocks.h>
#include <dn/builder/calibration_state.h>
#include <dn/error.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "testing/expect_invalid.h"
#include "testing/random.h"

namespace dn::builder_test {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kBeams = 3;

/// Returns a flight whose scanner has three beams about y; the last one measured no pair.
Flight BeamFlight() {
  Flight flight;
  flight.config.lidar.emplace();
  flight.config.lidar->scan_axis_s = {0.0, 2.0, 0.0};
  flight.config.lidar->nadir_axis_s = {1.0, 0.0, 0.0};
  flight.config.lidar->beams = BeamConfig{kBeams, {}, 1e-3, 0.02};
  flight.pairs.emplace();
  LidarPair pair;
  pair.beam_i = 0;
  pair.beam_j = 1;
  flight.pairs->pairs = {pair, pair};
  flight.pairs->pairs[1].beam_j = kNoBeam;
  return flight;
}

LidarReading Read(const BeamUnknown& unknown, const VectorXd& value, const Vector3d& u_s,
                  int beam) {
  const auto effect =
      std::get<std::shared_ptr<const LidarEffect>>(BeamAction(BeamFlight(), unknown));
  const double* const values = value.data();
  return Corrected({effect}, &values, 100.0, u_s, 0, beam);
}

TEST(BeamUnknowns, AreTheAnglesAndRangesOfTheMeasuredBeams) {
  Flight flight = BeamFlight();
  const std::vector<BeamUnknown> unknowns = FindBeamUnknowns(flight);
  ASSERT_EQ(unknowns.size(), 2u);
  EXPECT_EQ(unknowns[0].name, "lidar_beam_angle");
  EXPECT_EQ(unknowns[1].name, "lidar_beam_range");
  EXPECT_EQ(unknowns[0].ends, (std::vector<long>{2, 1, 0}));
  EXPECT_TRUE(IsBeamUnknown("lidar_beam_range/front"));
  EXPECT_FALSE(IsBeamUnknown("lidar_range_offset"));
  const CalibrationState state = AssumedCalibration(flight);
  ASSERT_EQ(state.effects.size(), 2u);
  EXPECT_EQ(state.effects[1].value, VectorXd::Zero(kBeams));
  flight.config.lidar->beams->angle_sigma_rad = 0.0;  // known exactly
  EXPECT_EQ(FindBeamUnknowns(flight).size(), 1u);
  for (LidarPair& pair : flight.pairs->pairs) pair.beam_i = pair.beam_j = kNoBeam;
  EXPECT_TRUE(FindBeamUnknowns(flight).empty());
}

TEST(BeamUnknowns, ABeamThatDoesNotExistIsRefused) {
  Flight flight = BeamFlight();
  flight.pairs->pairs[0].beam_j = kBeams;
  EXPECT_THROW(FindBeamUnknowns(flight), InvalidInput);
}

TEST(BeamUnknowns, AreTheOnlyEffectsWithMoreThanThreeValues) {
  Flight flight = BeamFlight();
  flight.config.lidar->beams->count = 4;
  flight.config.gnss.emplace();
  CalibrationState state = AssumedCalibration(flight);
  Network net;
  EXPECT_NO_THROW(CalibrationBlocks(flight, state, &net));
  state.effects[0].name = "own_effect";
  Network other;
  testing::ExpectInvalid([&] { CalibrationBlocks(flight, state, &other); },
                         "only effects with one to three values", 0);
}

TEST(BeamUnknowns, OfASecondScannerHaveItsNameAndActOnItsReadings) {
  Flight flight = BeamFlight();
  flight.config.more_scanners = {*flight.config.lidar};
  flight.config.more_scanners[0].name = "angle";
  flight.config.lidar->beams.reset();
  for (LidarPair& pair : flight.pairs->pairs) pair.scanner_i = pair.scanner_j = 1;
  const std::vector<BeamUnknown> unknowns = FindBeamUnknowns(flight);
  ASSERT_EQ(unknowns.size(), 2u);
  EXPECT_EQ(unknowns[1].name, "lidar_beam_range/angle");
  const auto effect = std::get<std::shared_ptr<const LidarEffect>>(BeamAction(flight, unknowns[1]));
  const Vector3d value(1.0, 2.0, 3.0), u_s(100.0, 0.0, 0.0);
  const double* const values = value.data();
  EXPECT_EQ(Corrected({effect}, &values, 100.0, u_s, 0, 1).u_s, u_s);
  EXPECT_EQ(Corrected({effect}, &values, 100.0, u_s, 1, 1).u_s, Vector3d(98.0, 0.0, 0.0));
}

TEST(BeamUnknowns, DerivativesAgreeWithDifferences) {
  constexpr double kStep = 1e-6;
  for (const BeamUnknown& unknown : FindBeamUnknowns(BeamFlight())) {
    for (unsigned seed = 0; seed < 10; ++seed) {
      SCOPED_TRACE(unknown.name + " seed " + std::to_string(seed));
      std::mt19937 rng(seed);
      const Vector3d u_s = Vector3d(100.0, 3.0, 0.0) + testing::RandomVector(rng, 40.0);
      const VectorXd value = testing::RandomVector(rng, 0.02);
      for (int beam = 0; beam < kBeams; ++beam) {
        const LidarReading at = Read(unknown, value, u_s, beam);
        for (int c = 0; c < kBeams; ++c) {
          const VectorXd d = kStep * VectorXd::Unit(kBeams, c);
          const Vector3d change =
              Read(unknown, value + d, u_s, beam).u_s - Read(unknown, value - d, u_s, beam).u_s;
          EXPECT_LE((at.J_u.col(c) - change / (2.0 * kStep)).norm(), 1e-6) << beam << c;
        }
      }
    }
  }
}

// The definition of the corrections: the angle toward the axis grows, the range becomes shorter.
TEST(BeamUnknowns, CorrectTheReadingsOfTheirBeam) {
  const std::vector<BeamUnknown> unknowns = FindBeamUnknowns(BeamFlight());
  const Vector3d u_s(100.0, 10.0, -30.0), value(0.01, -0.02, 0.03);
  const auto angle = [](const Vector3d& u) { return std::asin(u.normalized().y()); };
  for (int beam = 0; beam < kBeams; ++beam) {
    const Vector3d turned = Read(unknowns[0], value, u_s, beam).u_s;
    EXPECT_NEAR(angle(turned) - angle(u_s), value[beam], 1e-14);
    EXPECT_NEAR(turned.norm(), u_s.norm(), 1e-12);
    EXPECT_NEAR(turned.x() / turned.z(), u_s.x() / u_s.z(), 1e-12);
    const Vector3d shorter = Read(unknowns[1], value, u_s, beam).u_s;
    EXPECT_LE((shorter - (1.0 - value[beam] / u_s.norm()) * u_s).norm(), 1e-12);
  }
  for (const BeamUnknown& unknown : unknowns) {
    EXPECT_EQ(Read(unknown, value, u_s, kNoBeam).u_s, u_s);
  }
}

// The prior of the measured beams is that of independent errors without their mean.
TEST(BeamUnknowns, ThePriorHasNoMeanOfTheMeasuredBeams) {
  const BeamUnknown unknown = FindBeamUnknowns(BeamFlight())[1];
  const Eigen::MatrixXd R = BeamPrior(unknown).sqrt_information();
  const Eigen::MatrixXd C = (R.transpose() * R).inverse();
  EXPECT_NEAR(std::sqrt(C(0, 0)), unknown.PriorSigma(0), 1e-6);
  EXPECT_NEAR(std::sqrt(C(1, 1)), 0.02 * std::sqrt(0.5), 1e-6);
  EXPECT_NEAR(std::sqrt(C(2, 2)), 0.02, 1e-12);
  EXPECT_LT(C(0, 0) + 2.0 * C(0, 1) + C(1, 1), 1e-5 * C(0, 0));
  EXPECT_EQ(C(0, 2), 0.0);
}

}  // namespace dn::builder_test
