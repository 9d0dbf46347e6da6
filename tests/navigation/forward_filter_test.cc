#include <dn/navigation/alignment.h>
#include <dn/navigation/directed_filter.h>
#include <dn/sim/random.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>

#include "testing/short_flights.h"
#include "testing/tolerances.h"

namespace dn::navigation_test {

using testing::DroneScenario;
using testing::kSigmas;

constexpr double kSigmaAttitudeRad = 0.05;
constexpr double kSigmaPositionM = 0.05;
constexpr double kSigmaVelocityMps = 0.3;
// Quantile of chi-square with nine degrees of freedom; 6e-5 is above it.
constexpr double kNavBound = 34.5;

class ForwardFilter : public ::testing::Test {
 protected:
  ForwardFilter() : sim_(Simulate(WithoutPairs(), Seeded(5))) {
    times_ = GnssTimes(sim_.flight, NetworkSpan(sim_.flight, false));
  }

  static Scenario WithoutPairs() {
    Scenario scenario = DroneScenario();
    scenario.pairs.count = 0;
    return scenario;
  }
  static SimulateOptions Seeded(std::uint64_t seed) {
    SimulateOptions options;
    options.seed = seed;
    return options;
  }

  /// Returns an initial state with errors drawn from its covariance.
  FilterState Start() const {
    Random random(11, "start");
    MapPose pose = sim_.truth->Pose(times_.front());
    pose.q_mb = pose.q_mb * Exp(Eigen::Vector3d(kSigmaAttitudeRad * random.Normal3()));
    pose.p_mb += kSigmaPositionM * random.Normal3();
    pose.v_m += kSigmaVelocityMps * random.Normal3();
    return MakeFilterState(sim_.flight, pose, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                           Eigen::Vector3d::Constant(kSigmaAttitudeRad), kSigmaPositionM,
                           kSigmaVelocityMps);
  }

  /// Returns estimated minus true attitude (right), position and velocity.
  Eigen::Matrix<double, 9, 1> NavError(const FilterState& state) const {
    const MapPose truth = sim_.truth->Pose(state.pose.t_s);
    Eigen::Matrix<double, 9, 1> e;
    e << Log(Eigen::Quaterniond(truth.q_mb.conjugate() * state.pose.q_mb)),
        state.pose.p_mb - truth.p_mb, state.pose.v_m - truth.v_m;
    return e;
  }

  SimulatedFlight sim_;
  std::vector<double> times_;
};

/// Returns the mean square of the normalised innovations, per axis.
double MeanSquare(const FilterRun& run) {
  double nis = 0.0;
  for (const Innovation& innovation : run.innovations) nis += innovation.nis;
  return nis / (3.0 * static_cast<double>(run.innovations.size()));
}

TEST_F(ForwardFilter, InnovationsInAVibrationThatIsStatedAreOfUnitVariance) {
  Scenario scenario = WithoutPairs();
  scenario.effects = {{"imu_vibration", {2.0, 20.0}, {}, {}}};
  scenario.effects[0].times.window_s = {381100.0, 381140.0};
  sim_ = Simulate(scenario, Seeded(5));
  const double scatter = std::sqrt(2.0 / (3.0 * static_cast<double>(times_.size())));
  EXPECT_GT(MeanSquare(RunForwardFilter(sim_.flight, times_, Start())),
            1.0 + 2 * kSigmas * scatter);
  sim_.flight.config.imu->model.vibration = {{381100.0, 381140.0, 2.0 * kRadPerDeg, 20.0}};
  EXPECT_NEAR(MeanSquare(RunForwardFilter(sim_.flight, times_, Start())), 1.0, kSigmas * scatter);
}

TEST_F(ForwardFilter, InnovationsAreWhiteAndOfUnitVariance) {
  const FilterRun run = RunForwardFilter(sim_.flight, times_, Start());
  ASSERT_EQ(run.innovations.size(), times_.size());
  double nis = 0.0, lagged = 0.0;
  for (std::size_t k = 0; k < run.innovations.size(); ++k) {
    EXPECT_FALSE(run.innovations[k].velocity);
    EXPECT_EQ(run.innovations[k].t_s, times_[k]);
    nis += run.innovations[k].nis;
    if (k > 0) lagged += run.innovations[k].normalised.dot(run.innovations[k - 1].normalised);
  }
  const double n = 3.0 * static_cast<double>(times_.size());
  EXPECT_NEAR(nis / n, 1.0, kSigmas * std::sqrt(2.0 / n));
  EXPECT_NEAR(lagged / n, 0.0, kSigmas * std::sqrt(1.0 / n));
}

// Time-correlated errors of 20 s are twice as large as the white noise. With them as states, the
// innovations are white with unit variance, and the positions agree with their covariance. Without
// them they are not.
TEST_F(ForwardFilter, InnovationsAreWhiteWithTimeCorrelatedGnssErrors) {
  Scenario scenario = WithoutPairs();
  scenario.gnss.processes = {{{0.03, 0.03, 0.06}, 20.0}};
  SimulatedFlight sim = Simulate(scenario, Seeded(5));
  ASSERT_EQ(sim.flight.config.gnss->processes, scenario.gnss.processes);
  const double n = 3.0 * static_cast<double>(times_.size());
  const auto nis = [&] {
    const FilterRun run = RunForwardFilter(
        sim.flight, times_,
        MakeFilterState(sim.flight, Start().pose, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                        Eigen::Vector3d::Constant(kSigmaAttitudeRad), kSigmaPositionM,
                        kSigmaVelocityMps));
    EXPECT_EQ(run.last.covariance.rows(), run.last.covariance.cols());
    double sum = 0.0, lagged = 0.0;
    for (std::size_t k = 0; k < run.innovations.size(); ++k) {
      sum += run.innovations[k].nis;
      if (k > 0) lagged += run.innovations[k].normalised.dot(run.innovations[k - 1].normalised);
    }
    return std::pair(sum / n, lagged / n);
  };
  const auto [mean_nis, lag1] = nis();
  EXPECT_NEAR(mean_nis, 1.0, kSigmas * std::sqrt(2.0 / n));
  EXPECT_NEAR(lag1, 0.0, kSigmas * std::sqrt(1.0 / n));
  sim.flight.config.gnss->processes.clear();
  EXPECT_GT(nis().first, 1.0 + kSigmas * std::sqrt(2.0 / n));
}

TEST_F(ForwardFilter, ConvergesToTheTruthAsItsCovarianceSays) {
  const FilterState start = Start();
  const FilterRun run = RunForwardFilter(sim_.flight, times_, start);
  ASSERT_EQ(run.states.size(), times_.size());
  const Eigen::Matrix<double, 9, 9> P = run.last.covariance.topLeftCorner<9, 9>();
  EXPECT_LT((P - P.transpose()).cwiseAbs().maxCoeff(), 1e-9 * P.diagonal().maxCoeff());
  const Eigen::Matrix<double, 9, 1> e = NavError(run.last);
  EXPECT_LT(e.dot(P.ldlt().solve(e)), kNavBound);
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::sqrt(P(i, i)), 0.1 * kSigmaAttitudeRad);
  const Eigen::Vector3d gyro_error = run.last.TotalGyroBias() - sim_.gyro_bias_radps.back();
  const double gyro_constant = sim_.flight.config.imu->model.gyro.processes.front().sigma;
  EXPECT_LT(gyro_error.head<2>().norm(), gyro_constant) << "the level gyros are calibrated";
}

// Runs from the end of the flight, with initial errors as large as those of the forward filter.
TEST_F(ForwardFilter, ReverseFilterConvergesToTheTruthAsItsCovarianceSays) {
  Random random(12, "start");
  MapPose pose = sim_.truth->Pose(times_.back());
  pose.q_mb = pose.q_mb * Exp(Eigen::Vector3d(kSigmaAttitudeRad * random.Normal3()));
  pose.p_mb += kSigmaPositionM * random.Normal3();
  pose.v_m += kSigmaVelocityMps * random.Normal3();
  const DirectedRun run =
      RunFilter(sim_.flight, times_,
                MakeFilterState(sim_.flight, pose, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                Eigen::Vector3d::Constant(kSigmaAttitudeRad), kSigmaPositionM,
                                kSigmaVelocityMps),
                FilterDirection::kReverse);
  ASSERT_EQ(run.states.size(), times_.size());
  EXPECT_EQ(run.last.pose.t_s, times_.front());
  const double scatter = std::sqrt(2.0 / (3.0 * static_cast<double>(times_.size())));
  EXPECT_NEAR(MeanSquare(run), 1.0, kSigmas * scatter);
  const Eigen::Matrix<double, 9, 9> P = run.last.covariance.topLeftCorner<9, 9>();
  const Eigen::Matrix<double, 9, 1> e = NavError(run.last);
  EXPECT_LT(e.dot(P.ldlt().solve(e)), kNavBound);
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::sqrt(P(i, i)), 0.1 * kSigmaAttitudeRad);
  EXPECT_LT(run.sigma_heading_rad.back(), 0.1 * kSigmaAttitudeRad);
}

TEST_F(ForwardFilter, StopsAtTheEndTime) {
  FilterOptions options;
  options.t_end_s = times_[10] + 0.1;
  const FilterRun run = RunForwardFilter(sim_.flight, times_, Start(), options);
  EXPECT_EQ(run.states.size(), 11U);
  EXPECT_EQ(run.innovations.size(), 11U);
  EXPECT_EQ(run.last.pose.t_s, times_[10]);
}

TEST_F(ForwardFilter, HuberLimitsTheInfluenceOfAnOutlier) {
  const std::size_t bad = times_.size() / 2;
  for (MapGnssEpoch& epoch : sim_.flight.gnss->epochs) {
    if (epoch.t_s == times_[bad]) epoch.p_m += 30.0 * epoch.R_m_enu.col(2);
  }
  FilterOptions options;
  const double pulled =
      NavError(RunForwardFilter(sim_.flight, times_, Start(), options).states[bad])
          .segment<3>(3)
          .norm();
  options.huber_sigmas = 4.0;
  const FilterRun run = RunForwardFilter(sim_.flight, times_, Start(), options);
  EXPECT_GT(run.innovations[bad].nis, 1e4);
  EXPECT_GT(pulled, 1.0);
  EXPECT_LT(NavError(run.states[bad]).segment<3>(3).norm(), 0.2);
}

TEST_F(ForwardFilter, UsesVelocitiesWhereTheyAreAndRespectsTheConfiguration) {
  Scenario scenario = WithoutPairs();
  scenario.gnss.velocity = true;
  sim_ = Simulate(scenario, Seeded(5));
  const FilterRun run = RunForwardFilter(sim_.flight, times_, Start());
  ASSERT_EQ(run.innovations.size(), 2 * times_.size());
  double nis = 0.0;
  for (const Innovation& innovation : run.innovations) nis += innovation.velocity * innovation.nis;
  const double n = 3.0 * static_cast<double>(times_.size());
  EXPECT_NEAR(nis / n, 1.0, kSigmas * std::sqrt(2.0 / n));
  sim_.flight.config.gnss->use_velocity = false;
  EXPECT_EQ(RunForwardFilter(sim_.flight, times_, Start()).innovations.size(), times_.size());
}

TEST_F(ForwardFilter, ComesBackAfterAHoleInTheInertialData) {
  const double t0_s = times_[100] + 0.2, t1_s = times_[104] + 0.2;
  std::erase_if(sim_.flight.imu->samples,
                [&](const ImuSample& s) { return s.t_s > t0_s + 1e-6 && s.t_s < t1_s - 1e-6; });
  sim_.flight.imu->gaps.push_back({t0_s, t1_s - 0.01});
  const FilterRun run = RunForwardFilter(sim_.flight, times_, Start());
  const Eigen::Matrix<double, 9, 1> e = NavError(run.last);
  const Eigen::Matrix<double, 9, 9> P = run.last.covariance.topLeftCorner<9, 9>();
  EXPECT_LT(e.dot(P.ldlt().solve(e)), kNavBound);
}

TEST_F(ForwardFilter, StartCovarianceHoldsTheModel) {
  const ImuModel& model = sim_.flight.config.imu->model;
  const FilterState state = Start();
  ASSERT_EQ(state.gyro_bias.size(), model.gyro.processes.size());
  ASSERT_EQ(state.covariance.rows(), 9 + 12);
  const Eigen::VectorXd sigma = state.covariance.diagonal().cwiseSqrt();
  EXPECT_DOUBLE_EQ(sigma[0], kSigmaAttitudeRad);
  EXPECT_DOUBLE_EQ(sigma[3], kSigmaPositionM);
  EXPECT_DOUBLE_EQ(sigma[6], kSigmaVelocityMps);
  EXPECT_DOUBLE_EQ(sigma[9], model.gyro.processes[0].sigma);
  EXPECT_DOUBLE_EQ(sigma[12], model.gyro.processes[1].sigma);
  EXPECT_DOUBLE_EQ(sigma[15], model.accel.processes[0].sigma);
}

}  // namespace dn::navigation_test
