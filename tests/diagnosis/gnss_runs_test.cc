#include "gnss_runs.h"

#include <dn/adjustment/words.h>
#include <dn/sim/random.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "testing/short_flights.h"

namespace dn::diagnosis_test {
namespace {

using diagnosis_internal::LogGnssOverInertial;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kPositions = 30;
constexpr int kDraws = 200;

/// Covariance of a trajectory over a gap of GNSS, in units of the noise of GNSS. The position is a
/// twice integrated random walk, and it and the velocity are known at both ends. The axes are
/// independent.
MatrixXd BridgeCovariance(double sigma_in_the_middle) {
  const Index steps = kPositions + 2;
  MatrixXd position = MatrixXd::Zero(steps + 1, steps), velocity = position;
  for (Index k = 0; k < steps; ++k) {
    velocity.row(k + 1) = velocity.row(k);
    velocity(k + 1, k) += 1.0;
    position.row(k + 1) = position.row(k) + 0.5 * (velocity.row(k) + velocity.row(k + 1));
  }
  MatrixXd known(2, steps);
  known << position.row(steps), velocity.row(steps);
  const MatrixXd inside = position.middleRows(1, kPositions);
  const MatrixXd cross = inside * known.transpose();
  const MatrixXd bridged =
      inside * inside.transpose() -
      cross * (known * known.transpose()).ldlt().solve(MatrixXd(cross.transpose()));
  const double scale =
      sigma_in_the_middle * sigma_in_the_middle / bridged(kPositions / 2, kPositions / 2);
  MatrixXd H = MatrixXd::Zero(3 * kPositions, 3 * kPositions);
  for (Index i = 0; i < kPositions; ++i) {
    for (Index j = 0; j < kPositions; ++j) {
      H.block<3, 3>(3 * i, 3 * j) = scale * bridged(i, j) * Eigen::Matrix3d::Identity();
    }
  }
  return H;
}

/// Draws errors of a run of positions, and counts which of them are of GNSS by their shape.
class Runs : public ::testing::TestWithParam<double> {
 protected:
  Runs() : H_(BridgeCovariance(GetParam())), root_(H_.llt().matrixL()) {}

  /// Returns the share of draws that are decided for GNSS, or for the inertial data. `error` draws
  /// the error of the sensor that is wrong, in units of the noise of GNSS.
  template <class Error>
  double Share(bool (GnssRunCheck::*decided)() const, const Error& error) {
    const MatrixXd L = Eigen::Matrix3d::Identity().replicate<kPositions, 1>();
    int count = 0;
    for (int k = 0; k < kDraws; ++k) {
      const VectorXd r = root_ * White() + White() + error();
      GnssRunCheck check;
      check.log_gnss_over_inertial = LogGnssOverInertial(r, H_, L);
      count += (check.*decided)() ? 1 : 0;
    }
    return static_cast<double>(count) / kDraws;
  }

  VectorXd White() {
    VectorXd white(3 * kPositions);
    for (double& value : white) value = random_.Normal();
    return white;
  }

  MatrixXd H_, root_;
  Random random_{7, "runs of positions"};
};

INSTANTIATE_TEST_SUITE_P(
    SigmaInTheMiddle, Runs, ::testing::Values(0.3, 3.0, 30.0), [](const auto& sigma) {
      return std::string(sigma.param < 1.0 ? "small" : sigma.param < 10.0 ? "middle" : "large");
    });

TEST_P(Runs, AnOffsetWithSharpEndsIsOfGnss) {
  const double size = 10.0 * std::max(1.0, GetParam());
  EXPECT_GT(Share(&GnssRunCheck::is_gnss,
                  [&]() -> VectorXd {
                    return (size * random_.Normal3().normalized()).replicate<kPositions, 1>();
                  }),
            0.99);
}

TEST_P(Runs, WhiteNoiseOfAnotherSizeIsOfGnss) {
  EXPECT_GT(Share(&GnssRunCheck::is_gnss, [&]() -> VectorXd { return 10.0 * White(); }), 0.99);
}

TEST_P(Runs, AnErrorOfTheInertialDataIsNotOfGnss) {
  for (const double times : {3.0, 10.0, 100.0}) {
    const auto error = [&]() -> VectorXd { return times * root_ * White(); };
    EXPECT_LT(Share(&GnssRunCheck::is_gnss, error), 0.01) << times;
    if (times * GetParam() > 20.0) {
      EXPECT_GT(Share(&GnssRunCheck::is_inertial, error), 0.95) << times;
    }
  }
}

// A jolt of one interval: the error grows in proportion to time from it on, and the known ends
// bend it back.
TEST_P(Runs, AJoltIsOfTheInertialData) {
  EXPECT_GT(Share(&GnssRunCheck::is_inertial,
                  [&]() -> VectorXd {
                    const auto at = static_cast<Index>(random_.Uniform(3.0, kPositions - 3.0));
                    const VectorXd shape = H_.middleCols(3 * at, 3) * random_.Normal3();
                    return 30.0 * std::max(1.0, GetParam()) * shape / shape.cwiseAbs().maxCoeff();
                  }),
            0.95);
}

TEST(GnssRunsManyRuns, AJumpOfTheAntennaIsNotDoubted) {
  SimulatedFlight sim = testing::Fly(testing::DroneScenario(), 3);
  auto& epochs = sim.flight.gnss->epochs;
  const double middle_s = 0.5 * (epochs.front().t_s + epochs.back().t_s);
  for (MapGnssEpoch& epoch : epochs) {
    if (std::abs(epoch.t_s - middle_s) < 10.0) epoch.p_m += Eigen::Vector3d(0.5, 0.0, 0.0);
  }
  const Solution solution(sim.flight);
  ASSERT_EQ(solution.model_check().gnss_runs.size(), 1U);
  const GnssRunCheck& run = solution.model_check().gnss_runs.front();
  EXPECT_TRUE(run.is_gnss()) << run.log_gnss_over_inertial;
  EXPECT_GT(run.positions, 30);
  EXPECT_EQ(solution.CheckedBoresight().verdict, Verdict::kCalibrated);
}

TEST(GnssRunsManyRuns, AVibrationIsNotTakenForAnErrorOfGnss) {
  for (const char* size : {"0.3, 1.0", "0.02, 3"}) {
    SCOPED_TRACE(size);
    const SimulatedFlight sim =
        testing::Fly(testing::DroneScenario("effects: [{effect: imu_vibration, value: [" +
                                            std::string(size) + "], window_s: [381100, 381110]}]"),
                     3);
    const Solution solution(sim.flight);
    const std::vector<GnssRunCheck>& runs = solution.model_check().gnss_runs;
    ASSERT_EQ(runs.size(), 1U);
    EXPECT_TRUE(runs.front().is_inertial()) << runs.front().log_gnss_over_inertial;
    EXPECT_LT(runs.front().t0_s, 381110.0);
    EXPECT_GT(runs.front().t1_s, 381100.0);
    EXPECT_THAT(Words(solution.CheckedBoresight().reasons),
                ::testing::Contains(::testing::HasSubstr("GNSS positions in a row")));
    EXPECT_EQ(solution.CheckedBoresight().verdict, Verdict::kContradicted);
  }
}

}  // namespace
}  // namespace dn::diagnosis_test
