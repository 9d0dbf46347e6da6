#include <dn/adjustment/result.h>
#include <dn/diagnosis/result_files.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/solvers/score_test.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "network_hypotheses.h"
#include "testing/short_flights.h"
#include "testing/tolerances.h"

namespace dn::diagnosis_test {

using testing::AircraftScenario;
using testing::Calibration;
using testing::DroneScenario;
using testing::Fly;
using testing::kSigmas;

struct EffectCase {
  std::string unknown;
  std::string value;  ///< as written in the scenario
  std::vector<double> truth;
  std::vector<double> prior_sigma = {};  ///< empty: no prior
  bool aircraft = false;
  EffectTimes times = {};
};

SimulatedFlight FlyWith(const EffectCase& effect) {
  const std::string entry = "effects: [{effect: " + effect.unknown + ", value: " + effect.value +
                            FormatEffectTimes(effect.times) + "}]";
  return Fly(effect.aircraft ? AircraftScenario(entry) : DroneScenario(entry), 8);
}

/// A constant offset of the GNSS positions in a time window.
diagnosis_internal::Library StepInWindow(const FlightNetwork& network, const EffectTimes& times) {
  constexpr std::size_t kPositionBlock = 1;
  EffectModel columns;
  for (const GnssEdge& edge : network.gnss().edges()) {
    const MapGnssEpoch& epoch = network.flight().gnss->epochs[edge.epoch];
    Eigen::VectorXd r;
    std::vector<Eigen::MatrixXd> J;
    if (!times.During(epoch.t_s) || !network.net().EvaluateFactor(edge.position, &r, &J)) continue;
    const Eigen::Matrix3d R_m_enu = epoch.R_m_enu;
    columns.push_back({edge.position, Eigen::MatrixXd(J[kPositionBlock] * R_m_enu)});
  }
  diagnosis_internal::Library library;
  library.Add(diagnosis_internal::MakeHypothesis(EffectId::kGnssPositionStep), std::move(columns));
  return library;
}

/// Estimate of the effect, and its predicted shift of the boresight, from the fit without the
/// effect.
struct Foretold {
  Eigen::VectorXd estimate;
  Eigen::Vector3d boresight_rad;
};

Foretold Foretell(const EffectCase& effect, const Calibration& without) {
  const FlightNetwork& network = *without.adjustment.network;
  Foretold best;
  double most = -1.0;
  // The model check does not search for the window of a step, so the test states it.
  const diagnosis_internal::Library library =
      effect.unknown == "gnss_position_step" ? StepInWindow(network, effect.times)
                                             : diagnosis_internal::MakeNetworkHypotheses(network);
  for (const diagnosis_internal::Hypothesis& hypothesis : library.hypotheses) {
    if (hypothesis.name != effect.unknown) continue;
    const JointScore score = ScoreEffects(without.marginals, {library.blocks[hypothesis.block]},
                                          {network.calibration().boresight().id});
    const ScoreTest test = TestJointly(score, score.Components(0));
    if (test.statistic <= most) continue;
    most = test.statistic;
    best.estimate = hypothesis.per_si * test.estimate;
    best.boresight_rad = score.shift * test.estimate;
  }
  return best;
}

class EstimatesAnEffect : public ::testing::TestWithParam<EffectCase> {};

TEST_P(EstimatesAnEffect, WithinItsSigmasAndAsPredicted) {
  const EffectCase& effect = GetParam();
  SimulatedFlight sim = FlyWith(effect);
  const Calibration without(sim.flight);
  Flight estimating = sim.flight;
  estimating.config.estimate = {
      {"boresight", {}},
      {.unknown = effect.unknown, .sigma = effect.prior_sigma, .times = effect.times}};
  const Calibration c(estimating);
  const auto unknowns = ExtractUnknowns(c.adjustment, c.marginals);
  ASSERT_EQ(unknowns.size(), 1U);
  EXPECT_EQ(unknowns[0].name, effect.unknown);
  EXPECT_EQ(unknowns[0].unit, FindEffect(effect.unknown)->components[0].unit);
  ASSERT_EQ(unknowns[0].value.size(), effect.truth.size());
  double information = 0.0;
  for (std::size_t i = 0; i < effect.truth.size(); ++i) {
    const double sigma = unknowns[0].sigma[i];
    EXPECT_NEAR(unknowns[0].value[i], effect.truth[i], kSigmas * sigma) << "component " << i;
    information = std::max(information, std::abs(effect.truth[i]) / sigma);
    if (!effect.prior_sigma.empty()) {
      EXPECT_LE(sigma, effect.prior_sigma.front() * (1.0 + 1e-9));
    }
  }
  EXPECT_GT(information, 5.0) << "the flight separates the effect from no effect";
  const Eigen::Vector3d e = c.BoresightError(sim.boresight_rad);
  const Eigen::Vector3d sigma = c.boresight.sigma_rad();
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(e[i]), kSigmas * sigma[i]);

  if (!effect.prior_sigma.empty()) return;  // the score test does not include the prior
  constexpr double kFirstOrder = 0.05;
  const Foretold foretold = Foretell(effect, without);
  const Eigen::Vector3d moved = Log(Eigen::Quaterniond(Exp(without.boresight.angles_rad) *
                                                       Exp(c.boresight.angles_rad).conjugate()));
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(foretold.boresight_rad[i], moved[i], kFirstOrder * (moved.norm() + sigma[i])) << i;
  }
  for (std::size_t i = 0; i < effect.truth.size(); ++i) {
    EXPECT_NEAR(foretold.estimate[static_cast<Eigen::Index>(i)], unknowns[0].value[i],
                kFirstOrder * (std::abs(unknowns[0].value[i]) + unknowns[0].sigma[i]))
        << "component " << i;
  }
}

const EffectTimes kStep{.t0_s = 381160.0};
const EffectTimes kWindow{.window_s = std::pair(381090.0, 381130.0)};

constexpr auto kEffectName = [](const auto& tested) { return tested.param.unknown; };

INSTANTIATE_TEST_SUITE_P(
    Calibrate, EstimatesAnEffect,
    ::testing::Values(
        EffectCase{"boresight_drift", "[2, -1, 2]", {2.0, -1.0, 2.0}},
        EffectCase{"boresight_step", "[0.2, -0.1, 0.1]", {0.2, -0.1, 0.1}, {}, false, kStep}),
    kEffectName);

INSTANTIATE_TEST_SUITE_P(
    ManyRuns, EstimatesAnEffect,
    ::testing::Values(
        EffectCase{"gnss_lever_arm", "[0.10, -0.06, 0.08]", {0.10, -0.06, 0.08}},
        EffectCase{"gnss_time_offset", "0.003", {0.003}},
        EffectCase{"gnss_time_drift", "20", {20.0}},
        EffectCase{
            "gnss_position_step", "[0.03, -0.04, 0.05]", {0.03, -0.04, 0.05}, {}, false, kWindow},
        EffectCase{"lidar_time_offset", "0.01", {0.01}},
        EffectCase{"lidar_time_drift", "40", {40.0}},
        EffectCase{"lidar_range_offset", "0.2", {0.2}},
        EffectCase{"lidar_range_scale", "2000", {2000.0}},
        EffectCase{"lidar_angle_scale", "3000", {3000.0}},
        EffectCase{"lidar_scan_cone", "0.3", {0.3}}, EffectCase{"lidar_scan_torsion", "0.2", {0.2}},
        EffectCase{"gyro_scale_factor", "[1500, -800, 2000]", {1500.0, -800.0, 2000.0}},
        EffectCase{"gyro_misalignment", "[5, 4, -3]", {5.0, 4.0, -3.0}},
        EffectCase{"gyro_g_sensitivity", "[0.3, -0.3, 0.5]", {0.3, -0.3, 0.5}, {}, true},
        EffectCase{"accel_scale_factor", "[0, 0, 500]", {0.0, 0.0, 500.0}, {1000.0}, true},
        EffectCase{"accel_misalignment", "[0.5, -0.5, 0.3]", {0.5, -0.5, 0.3}, {1.0}, true},
        EffectCase{"gravity_tilt", "[20, -20]", {20.0, -20.0}, {60.0}, true},
        EffectCase{"gravity_disturbance", "300", {300.0}, {}, true},
        EffectCase{"lidar_lever_arm", "[0.15, -0.20, 0.05]", {0.15, -0.20, 0.05}, {0.2}}),
    kEffectName);

// One flight and its calibration, shared by the tests of the results.
struct CalibratedFlight {
  explicit CalibratedFlight(const Scenario& scenario)
      : sim(Fly(scenario, 4)),
        calibration(sim.flight),
        trajectory(calibration.solution.trajectory()) {}

  SimulatedFlight sim;
  Calibration calibration;
  TrajectoryResult trajectory;
};

const CalibratedFlight& Aircraft() {
  static const CalibratedFlight flight(AircraftScenario());
  return flight;
}

const CalibratedFlight& Drone() {
  static const CalibratedFlight flight(DroneScenario());
  return flight;
}

class Results : public ::testing::TestWithParam<bool> {
 protected:
  const FlightNetwork& network() const { return *calibration_.adjustment.network; }

  const CalibratedFlight& flight_ = GetParam() ? Aircraft() : Drone();
  const SimulatedFlight& sim_ = flight_.sim;
  const Calibration& calibration_ = flight_.calibration;
  const TrajectoryResult& trajectory_ = flight_.trajectory;
};

/// Expects a plausible mean square of normalised errors. They are correlated over minutes, so few
/// of them are independent.
void ExpectPlausible(double sum2, std::size_t n, const char* what) {
  const double mean = sum2 / static_cast<double>(n);
  EXPECT_GT(mean, 0.2) << what;
  EXPECT_LT(mean, 3.0) << what;
}

TEST_P(Results, TrajectorySigmasMatchTheErrors) {
  double position = 0.0, velocity = 0.0, level = 0.0, heading = 0.0;
  ASSERT_EQ(trajectory_.sigma.size(), network().nodes().size());
  for (std::size_t k = 0; k < network().nodes().size(); ++k) {
    const TrajectorySigma& sigma = trajectory_.sigma[k];
    const MapPose pose = network().trajectory().NodePose(k);
    const MapPose truth = sim_.truth->Pose(pose.t_s);
    const Eigen::Matrix3d R_enu_m = sim_.frame.R_m_enu(truth.p_mb).transpose();
    position +=
        (R_enu_m * (pose.p_mb - truth.p_mb)).cwiseQuotient(sigma.position_enu_m).squaredNorm();
    velocity +=
        (R_enu_m * (pose.v_m - truth.v_m)).cwiseQuotient(sigma.velocity_enu_mps).squaredNorm();
    Eigen::Vector3d rph = RollPitchHeading(ToNavPoint(pose, sim_.frame).q_nb) -
                          RollPitchHeading(ToNavPoint(truth, sim_.frame).q_nb);
    rph.z() = std::remainder(rph.z(), 2.0 * std::numbers::pi);
    rph = rph.cwiseQuotient(sigma.rph_rad);
    level += rph.head<2>().squaredNorm();
    heading += rph.z() * rph.z();
  }
  const std::size_t n = network().nodes().size();
  ExpectPlausible(position, 3 * n, "position");
  ExpectPlausible(velocity, 3 * n, "velocity");
  ExpectPlausible(level, 2 * n, "roll and pitch");
  ExpectPlausible(heading, n, "heading");
}

TEST_P(Results, BiasSigmasMatchTheErrors) {
  double gyro = 0.0, accel = 0.0;
  for (const BiasEstimate& bias : trajectory_.biases) {
    const std::size_t k = std::min(SampleRange(*sim_.flight.imu, bias.t_s, bias.t_s + 1.0).first,
                                   sim_.gyro_bias_radps.size() - 1);
    gyro += (bias.gyro_radps - sim_.gyro_bias_radps[k])
                .cwiseQuotient(bias.sigma_gyro_radps)
                .squaredNorm();
    accel += (bias.accel_mps2 - sim_.accel_bias_mps2[k])
                 .cwiseQuotient(bias.sigma_accel_mps2)
                 .squaredNorm();
  }
  ExpectPlausible(gyro, 3 * trajectory_.biases.size(), "gyro bias");
  ExpectPlausible(accel, 3 * trajectory_.biases.size(), "accelerometer bias");
}

TEST_P(Results, BoresightCovarianceIsOne) {
  const Eigen::Matrix3d C = calibration_.boresight.covariance_rad2;
  EXPECT_LT((C - C.transpose()).cwiseAbs().maxCoeff(), 1e-9 * C.diagonal().maxCoeff());
  EXPECT_EQ(Eigen::LLT<Eigen::Matrix3d>(C).info(), Eigen::Success);
  const Eigen::Matrix3d r = calibration_.boresight.correlation();
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(r(i, i), 1.0, 1e-12);
    for (int j = 0; j < 3; ++j) EXPECT_LE(std::abs(r(i, j)), 1.0 + 1e-12);
  }
  EXPECT_GE(calibration_.boresight.condition_number, 1.0);
  for (const BiasCorrelation& bias :
       {calibration_.boresight.gyro_bias, calibration_.boresight.accel_bias}) {
    EXPECT_GT(bias.rms, 0.0);
    EXPECT_LE(bias.rms, bias.max_abs);
    EXPECT_LE(bias.max_abs, 1.0);
    EXPECT_LE(bias.at_barycentre.cwiseAbs().maxCoeff(), bias.max_abs);
  }
}

TEST_P(Results, ReportedAnglesDescribeOneRotation) {
  const BoresightResult& b = calibration_.boresight;
  EXPECT_LT(Exp(b.angles_rad).angularDistance(QuaternionFromRollPitchHeading(b.euler_zyx_rad)),
            1e-12);
}

TEST_P(Results, DenseTrajectoryPassesThroughTheNodesAndStaysNearTheTruth) {
  constexpr double kSpacingS = 0.05;
  const std::vector<NavPoint> dense = DenseTrajectory(network(), kSpacingS);
  std::size_t node = 0;
  double previous_s = -1e300;
  for (const NavPoint& point : dense) {
    const MapPose pose = ToMapPose(point, sim_.frame);
    ASSERT_GT(point.t_s, previous_s);
    previous_s = point.t_s;
    if (node < network().nodes().size() && point.t_s == network().nodes()[node].t_s) {
      const MapPose at_node = network().trajectory().NodePose(node);
      EXPECT_LT((pose.p_mb - at_node.p_mb).norm(), 1e-6);
      EXPECT_LT(pose.q_mb.angularDistance(at_node.q_mb), 1e-9);
      ++node;
    }
    const TrajectorySigma& sigma = trajectory_.sigma[node - 1];
    const MapPose truth = sim_.truth->Pose(point.t_s);
    // Ten thousand points with correct sigmas have no error above five sigmas.
    ASSERT_LT((pose.p_mb - truth.p_mb).norm(), 5.0 * sigma.position_enu_m.norm()) << point.t_s;
    ASSERT_LT((pose.v_m - truth.v_m).norm(), 5.0 * sigma.velocity_enu_mps.norm()) << point.t_s;
    ASSERT_LT(pose.q_mb.angularDistance(truth.q_mb), 5.0 * sigma.rph_rad.norm()) << point.t_s;
  }
  EXPECT_EQ(node, network().nodes().size());
  EXPECT_GT(dense.size(), 5 * network().nodes().size() / 2);
  EXPECT_EQ(FormatSbet(DenseTrajectory(network(), kSpacingS, 3)), FormatSbet(dense));
}

TEST_P(Results, StatisticsCountTheSeries) {
  std::set<std::string> sensors;
  for (const SeriesStatistics& s : trajectory_.residuals) {
    sensors.insert(s.sensor);
    EXPECT_GT(s.count, 0);
    EXPECT_LE(s.variance, 1.5) << s.sensor << " " << s.axis << ": residuals are below their sigmas";
  }
  EXPECT_EQ(sensors,
            (std::set<std::string>{"inertial", "gnss position", "lidar p2p", "bias process"}));
  EXPECT_EQ(trajectory_.innovations.size(), 3U);
  const double n = 3.0 * static_cast<double>(trajectory_.figures.gnss_epochs);
  EXPECT_NEAR(trajectory_.nis_position, 1.0, kSigmas * std::sqrt(2.0 / n));
  EXPECT_EQ(trajectory_.nis_velocity, 0.0);
}

TEST_P(Results, FilesContainTheEstimates) {
  const ModelCheck check = CheckModel(calibration_.adjustment, calibration_.marginals, trajectory_);
  const Json json = CalibrationJson("x", calibration_.adjustment, trajectory_, check,
                                    calibration_.boresight, {}, {}, {0.1, 0.2, 0.3, 0.6});
  EXPECT_EQ(json["model_check"]["groups"].size(), check.groups.size());
  EXPECT_TRUE(json["model_check"]["effects"].empty());
  EXPECT_EQ(json["schema"], "dn.result/1");
  EXPECT_EQ(json["boresight"]["angles_deg"][2], calibration_.boresight.angles_rad[2] * kDegPerRad);
  EXPECT_TRUE(json["boresight"]["sigma_apriori_deg"].is_null());
  EXPECT_EQ(json["adjustment"]["nodes"], network().nodes().size());
  EXPECT_EQ(json["timing_s"]["total"], 0.6);
  const std::string sigmas = FormatTrajectorySigma(trajectory_.sigma);
  EXPECT_EQ(std::count(sigmas.begin(), sigmas.end(), '\n'),
            static_cast<long>(network().nodes().size()) + 1);
  const Json errors = ReferenceErrorsJson(network().flight(), network().trajectory().NodePoses());
  EXPECT_LT(errors["position_enu_rmse_m"][0].get<double>(), 0.05);
  EXPECT_GT(errors["nodes"].get<std::size_t>(), network().nodes().size() / 2);
}

INSTANTIATE_TEST_SUITE_P(Calibrate, Results, ::testing::Bool(),
                         [](const auto& tested) { return tested.param ? "Aircraft" : "Drone"; });

TEST(Observability, ConstantBoresightHasNoCovariance) {
  SimulatedFlight sim = Fly(DroneScenario(), 3);
  sim.flight.config.estimate = {{"gnss_lever_arm", {}}};
  const Adjustment adjustment = Adjust(sim.flight);
  const Marginals marginals(adjustment.network->net());
  EXPECT_THROW(ExtractBoresight(adjustment, marginals), RankDeficient);
}

// Measurements of one ground point from one pair of poses give three equations, however many they
// are. They leave one direction of the boresight almost undetermined.
TEST(Observability, OnePointSeenFromTwoPairsOfPosesIsNotACalibration) {
  SimulatedFlight sim = Fly(DroneScenario(), 3);
  const auto middle_s = [](const StripInterval& s) { return 0.5 * (s.t0_s + s.t1_s); };
  const Mounting& mounting = sim.scenario.lidar.mounting;
  const auto sight = [&](double t_s) {
    const MapPose pose = sim.truth->Pose(t_s);
    const Eigen::Vector3d arm_b = pose.q_mb.conjugate() * (Eigen::Vector3d(0, 15, 0) - pose.p_mb);
    return Eigen::Vector3d(
        mounting.R_bs_nominal.transpose() *
        (Exp(mounting.boresight_rad).conjugate() * (arm_b - sim.lidar_lever_arm_b_m)));
  };
  double later_s = 0.0;
  for (LidarPair& pair : sim.flight.pairs->pairs) {
    later_s = 0.02 - later_s;
    pair.t_i_s = middle_s(sim.strips[0]) + later_s;
    pair.t_j_s = middle_s(sim.strips[1]) + later_s;
    pair.u_i_s = sight(pair.t_i_s);
    pair.u_j_s = sight(pair.t_j_s);
  }
  const Calibration c(sim.flight);
  EXPECT_EQ(c.boresight.verdict, Verdict::kNotObservable);
  EXPECT_FALSE(c.boresight.reasons.empty());
  EXPECT_GT(c.boresight.condition_number, 1e3);
  const Eigen::Vector3d e = c.BoresightError(sim.boresight_rad);
  for (int i = 0; i < 3; ++i) EXPECT_LT(std::abs(e[i]), kSigmas * c.boresight.sigma_rad()[i]);
}

}  // namespace dn::diagnosis_test
