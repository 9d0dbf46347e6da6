#include <dn/adjustment/pair_residuals.h>
#include <dn/adjustment/pose_interpolator.h>
#include <dn/adjustment/result.h>
#include <dn/rotation.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "testing/short_flights.h"

namespace dn::adjustment_test {

constexpr double kSpacingS = 0.01;
// Tolerance: the pair factor integrates from the node, but the trajectory is interpolated at 100
// Hz.
constexpr double kInterpolationM = 2e-3;

class PairResidualsOfADrone : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    flight_ = new Flight(Simulate(testing::DroneScenario(), {}).flight);
    calibration_ = new testing::Calibration(*flight_);
    const FlightNetwork& network = *calibration_->adjustment.network;
    trajectory_ = new Trajectory(DenseTrajectory(network, kSpacingS));
    residuals_ = new std::vector<PairResidual>(
        PairResiduals(network, PoseInterpolator(trajectory_->ToMapPoses(network.flight().frame))));
  }
  static void TearDownTestSuite() {
    delete residuals_;
    delete trajectory_;
    delete calibration_;
    delete flight_;
  }

  static Flight* flight_;
  static testing::Calibration* calibration_;
  static Trajectory* trajectory_;
  static std::vector<PairResidual>* residuals_;
};

Flight* PairResidualsOfADrone::flight_ = nullptr;
testing::Calibration* PairResidualsOfADrone::calibration_ = nullptr;
Trajectory* PairResidualsOfADrone::trajectory_ = nullptr;
std::vector<PairResidual>* PairResidualsOfADrone::residuals_ = nullptr;

TEST_F(PairResidualsOfADrone, AreThoseOfTheAdjustment) {
  double mean_m = 0.0;
  for (const PairResidual& r : *residuals_) mean_m += r.after_enu_m.norm();
  mean_m /= static_cast<double>(residuals_->size());
  EXPECT_NEAR(mean_m, calibration_->adjustment.residual_final_m, 1e-12);
}

// With the estimated boresight as the assumed one, "before" equals "after".
TEST_F(PairResidualsOfADrone, BeforeAndAfterDifferByTheBoresight) {
  Flight calibrated = *flight_;
  calibrated.config.lidar->mounting.boresight_rad = calibration_->boresight.angles_rad;
  const PoseInterpolator poses(trajectory_->ToMapPoses(flight_->frame));
  for (std::size_t k = 0; k < residuals_->size(); ++k) {
    const LidarPair& pair = calibration_->adjustment.network->pairs().edges()[k].pair;
    const Mounting& mounting = calibrated.config.lidar->mounting;
    const Eigen::Vector3d difference = Georeference(poses.At(pair.t_i_s), mounting, pair.u_i_s) -
                                       Georeference(poses.At(pair.t_j_s), mounting, pair.u_j_s);
    const PairResidual& r = (*residuals_)[k];
    EXPECT_LT((difference - r.after_enu_m).norm(), kInterpolationM) << k;
    EXPECT_DOUBLE_EQ(r.i.range_m, pair.u_i_s.norm());
    EXPECT_LT(std::abs(r.i.scan_angle_rad), 40.0 * kRadPerDeg);  // the field of view is 75 deg
  }
}

TEST_F(PairResidualsOfADrone, SumsByPairsOfStrips) {
  const Json list = StripPairsJson(*residuals_);
  ASSERT_EQ(list.size(), 4u);  // three strips, and "all"
  long pairs = 0;
  for (std::size_t k = 0; k + 1 < list.size(); ++k) pairs += list[k]["pairs"].get<long>();
  EXPECT_EQ(pairs, static_cast<long>(residuals_->size()));
  EXPECT_EQ(list.back()["strips"], "all");
  EXPECT_EQ(list.back()["pairs"], pairs);
  EXPECT_NEAR(list.back()["after"]["mean_m"], calibration_->adjustment.residual_final_m, 1e-12);
  EXPECT_GT(list.back()["before"]["mean_m"], list.back()["after"]["mean_m"]);
  EXPECT_GT(list.back()["before"]["separation"]["above_16_cm"],
            list.back()["after"]["separation"]["above_16_cm"]);
  EXPECT_TRUE(StripPairsJson({}).empty());
}

TEST_F(PairResidualsOfADrone, OneRowForEach) {
  const std::string text = FormatPairResiduals(*residuals_);
  EXPECT_EQ(static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')),
            residuals_->size() + 1);
  const std::string row = text.substr(text.find('\n') + 1);
  EXPECT_EQ(std::count(row.begin(), row.begin() + static_cast<long>(row.find('\n')), ','), 16);
}

}  // namespace dn::adjustment_test
