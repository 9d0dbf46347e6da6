#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/adjustment/words.h>
#include <dn/diagnosis/model_check.h>
#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory_covariance.h>
#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <sstream>
#include <utility>

#include "testing/expect_invalid.h"
#include "testing/short_flights.h"
#include "testing/strip_pairs.h"
#include "testing/temp_folder.h"

namespace dn::adjustment_test {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using testing::BoresightError;
using ::testing::Contains;
using testing::ExpectInvalidIn;
using ::testing::HasSubstr;
using testing::TempFolder;

/// The small drone, calibrated on its true trajectory.
struct TruthFlight {
  SimulatedFlight simulated;
  Flight flight;

  explicit TruthFlight(bool noise, std::uint64_t seed = 1) {
    SimulateOptions options;
    options.noise = noise;
    options.seed = seed;
    simulated = Simulate(testing::DroneScenario(), options);
    flight = simulated.flight;
    flight.trajectory = flight.reference;
    flight.config.trajectory = TrajectoryConfig();
  }

  /// Rotates all attitudes by a constant error in body.
  void Turn(const std::function<Vector3d(double t_s)>& error_rad) {
    std::vector<NavPoint> points = flight.trajectory->points();
    for (NavPoint& point : points) {
      point.q_nb = (point.q_nb * Exp(Vector3d(error_rad(point.t_s)))).normalized();
    }
    flight.trajectory = Trajectory(points, flight.trajectory->notes());
  }
};

TEST(GaussHelmertFlight, NoiseFreeReturnsTheBoresight) {
  const TruthFlight truth(false);
  const GaussHelmertCalibration result = CalibrateGaussHelmert(truth.flight);
  // Interpolation error of a path with frequencies up to about 2 Hz that is sampled at 100 Hz. It
  // is 1e-5 of the amplitude of 0.02 rad, averaged over the pairs.
  constexpr double kInterpolationRad = 2e-7;
  EXPECT_LE(BoresightError(result.boresight.angles_rad, truth.simulated.boresight_rad).norm(),
            kInterpolationRad);
  EXPECT_EQ(result.boresight.verdict, Verdict::kCalibrated);
  EXPECT_EQ(result.diversity.strips, 3);
  EXPECT_TRUE(result.diversity.crossing);
  EXPECT_TRUE(result.diversity.sufficient());
  EXPECT_LT(result.interpolation.cubic_minus_linear_max_rad, 1e-3);
  EXPECT_GT(result.interpolation.cubic_minus_linear_rms_rad, 0.0);
}

TEST(GaussHelmertFlight, SigmaIncludesTheAbsorbedConstant) {
  TruthFlight truth(true);
  const Vector3d offset = Vector3d(0.05, -0.03, 0.10) * kRadPerDeg;
  truth.Turn([&](double) -> const Vector3d& { return offset; });
  truth.flight.config.trajectory->sigma_rp_rad = 0.05 * kRadPerDeg;
  truth.flight.config.trajectory->sigma_y_rad = 0.10 * kRadPerDeg;
  const GaussHelmertCalibration result = CalibrateGaussHelmert(truth.flight);
  const Vector3d expected =
      Log(Eigen::Quaterniond(Exp(Vector3d(-offset)) * Exp(truth.simulated.boresight_rad)));
  const Vector3d formal = *result.boresight.sigma_scaled_rad;
  const Vector3d absorbed_error = BoresightError(result.boresight.angles_rad, expected);
  for (int i = 0; i < 3; ++i) {
    // The lever arm of 0.25 m rotates with the body, but the boresight does not: 0.3 % of 100 m.
    EXPECT_LE(std::abs(absorbed_error[i]), 4.0 * formal[i] + 5e-3 * offset.norm()) << i;
  }
  // If the strips agree, the whole error is constant, or the sensor is better than its data sheet.
  constexpr double kStatedShare = 0.8;
  const Vector3d sigma = result.boresight.sigma_rad();
  EXPECT_GE(sigma.x(), 0.05 * kRadPerDeg * kStatedShare);
  EXPECT_GE(sigma.y(), 0.05 * kRadPerDeg * kStatedShare);
  EXPECT_GE(sigma.z(), 0.10 * kRadPerDeg * kStatedShare);
  const Vector3d error = BoresightError(result.boresight.angles_rad, truth.simulated.boresight_rad);
  EXPECT_LE((error.cwiseQuotient(sigma)).cwiseAbs().maxCoeff(), 3.0);
  EXPECT_THAT(Words(result.boresight.reasons),
              Contains(HasSubstr("times those of the normal matrix")));
}

TEST(GaussHelmertFlight, AbsorbedWhereTheAttitudeErrorIsNotAtNoiseLevel) {
  TruthFlight truth(true);
  // 0.14 m at 100 m; the pairs' noise is 0.03 m.
  truth.flight.config.trajectory->sigma_rp_rad = 0.08 * kRadPerDeg;
  const GaussHelmertCalibration stated = CalibrateGaussHelmert(truth.flight);
  EXPECT_EQ(stated.boresight.verdict, Verdict::kAbsorbed);
  EXPECT_THAT(Words(stated.boresight.reasons), Contains(HasSubstr("not those of the mounting")));
  // An unstated error that changes from strip to strip: one case is within twice the variance, the
  // other exceeds it and contradicts the statement.
  const auto unstated = [](double size) {
    TruthFlight flown(true);
    flown.Turn([size](double t_s) {
      return Vector3d(Vector3d(0.10, 0.08, 0.15) * size * kRadPerDeg * std::sin(t_s / 25.0));
    });
    GaussHelmertCalibration calibration = CalibrateGaussHelmert(flown.flight);
    const ModelCheck check = AssessModel(flown.flight, &calibration);
    return std::pair(std::move(calibration), check);
  };
  const GaussHelmertCalibration small = unstated(0.3).first;
  EXPECT_EQ(small.boresight.verdict, Verdict::kAbsorbed) << Words(small.boresight.reasons.front());
  const auto [large, check] = unstated(1.0);
  EXPECT_EQ(large.boresight.verdict, Verdict::kContradicted);
  EXPECT_THAT(Words(large.boresight.reasons), Contains(HasSubstr("not those of the mounting")));
  EXPECT_GT(check.groups.front().variance_ratio, 2.0);
}

TEST(GaussHelmertFlight, APriorThatContradictsThePairsIsNamed) {
  TruthFlight truth(true);
  truth.flight.config.lidar->boresight_sigma_rad = Vector3d::Constant(0.05 * kRadPerDeg);
  truth.flight.config.lidar->mounting.boresight_rad =
      truth.simulated.boresight_rad + Vector3d(0.0, 0.5, 0.0) * kRadPerDeg;
  GaussHelmertCalibration result = CalibrateGaussHelmert(truth.flight);
  AssessModel(truth.flight, &result);
  EXPECT_EQ(result.boresight.verdict, Verdict::kContradicted);
  EXPECT_THAT(Words(result.boresight.reasons), Contains(HasSubstr("lidar.boresight_sigma_deg")));
}

TEST(GaussHelmertFlight, AgreesWithTheNetworkOnATrueTrajectory) {
  TruthFlight truth(true);
  const testing::Calibration network(truth.flight);
  GaussHelmertCalibration gh = CalibrateGaussHelmert(truth.flight);
  const MethodDifference difference = Compare(gh.boresight, network.boresight);
  EXPECT_GT(difference.p_value, 1e-3);
  AssessAgainstNetwork(network.boresight, &gh);
  EXPECT_EQ(gh.boresight.verdict, Verdict::kCalibrated);
  EXPECT_THAT(Words(gh.boresight.reasons),
              Contains(HasSubstr("within what their covariances explain")));
}

TEST(GaussHelmertFlight, TheNetworkExposesAnUnstatedConstant) {
  TruthFlight truth(true);
  const testing::Calibration network(truth.flight);
  truth.Turn([](double) { return Vector3d(Vector3d(0.2, 0.2, 0.3) * kRadPerDeg); });
  GaussHelmertCalibration gh = CalibrateGaussHelmert(truth.flight);
  EXPECT_EQ(gh.boresight.verdict, Verdict::kCalibrated);  // the pairs do not show it
  AssessAgainstNetwork(network.boresight, &gh);
  EXPECT_EQ(gh.boresight.verdict, Verdict::kAbsorbed);
  EXPECT_THAT(Words(gh.boresight.reasons), Contains(HasSubstr("above its stated sigma")));
}

TEST(GaussHelmertFlight, PValueOfADifference) {
  BoresightResult a, b;
  a.covariance_rad2 = 1.5 * Eigen::Matrix3d::Identity();
  b.covariance_rad2 = 0.5 * Eigen::Matrix3d::Identity();
  EXPECT_NEAR(Compare(a, b).p_value, 1.0, 1e-12);
  // A left perturbation of sqrt(7.815) sigmas: the 5 % point of chi-square with three degrees of
  // freedom.
  a.angles_rad = Vector3d(std::sqrt(7.815), 0, 0);
  const MethodDifference difference = Compare(a, b);
  EXPECT_NEAR(difference.mahalanobis2, 7.815, 1e-9);
  EXPECT_NEAR(difference.p_value, 0.05, 1e-4);
  EXPECT_NEAR(difference.sigma_rad().x(), 1.0, 1e-12);
}

TEST(GaussHelmertFlight, ADifferenceIsNeverBetterKnownThanATenthOfTheVariance) {
  BoresightResult a, b;
  a.covariance_rad2 = Vector3d(1.0, 1.0, 1.0).asDiagonal();
  b.covariance_rad2 = Vector3d(1.01, 0.99, 0.36).asDiagonal();
  const Vector3d sigma = Compare(a, b).sigma_rad();
  EXPECT_NEAR(sigma.x(), std::sqrt(0.101), 1e-12);
  EXPECT_NEAR(sigma.y(), std::sqrt(0.1), 1e-12);
  EXPECT_NEAR(sigma.z(), 0.8, 1e-12);
  // With a trajectory of better sensors, the Gauss-Helmert adjustment is the efficient method.
  b.covariance_rad2 = 5.0 * Eigen::Matrix3d::Identity();
  EXPECT_NEAR(Compare(a, b).sigma_rad().x(), 2.0, 1e-12);
}

// ---- Standard deviations of the trajectory -----------------------------------------------------

std::string SigmaText(double begin_s, double end_s, const std::string& rest) {
  std::ostringstream text;
  text.precision(12);
  text << begin_s << rest << "\n" << end_s << rest << "\n";
  return text.str();
}

struct WithSigmaFile {
  TempFolder folder;
  TruthFlight truth;

  explicit WithSigmaFile(const std::string& text, bool noisy = false) : truth(noisy) {
    folder.Write("trajectory_sigma.txt", text);
    truth.flight.config.folder = folder.path();
  }
  TrajectoryAccuracy Read() const {
    return ReadTrajectoryAccuracy(truth.flight, MakeGaussHelmertProblem(truth.flight));
  }
};

TEST(TrajectoryAccuracy, ComesFromTheFileBesideTheTrajectory) {
  const WithSigmaFile flight(
      SigmaText(380000, 382000, ", 0.01, 0.02, 0.03, 0.1, 0.1, 0.1, 0.004, 0.005, 0.006"));
  const TrajectoryAccuracy accuracy = flight.Read();
  EXPECT_EQ(accuracy.source, "trajectory_sigma.txt");
  EXPECT_LE((accuracy.sigma_ned_m - Vector3d(0.02, 0.01, 0.03)).norm(), 1e-12);
  EXPECT_LE((accuracy.sigma_rph_rad / kRadPerDeg - Vector3d(0.004, 0.005, 0.006)).norm(), 1e-12);
  // For a level body, roll, pitch and heading are nearly rotations about its own axes.
  const Vector3d body = accuracy.attitude_covariance_rad2.diagonal().cwiseSqrt() / kRadPerDeg;
  EXPECT_LE((body - Vector3d(0.004, 0.005, 0.006)).norm(), 2e-4);
}

TEST(TrajectoryAccuracy, ComesFromTheSectionWithoutAFile) {
  const TruthFlight truth(false);
  const TrajectoryAccuracy accuracy =
      ReadTrajectoryAccuracy(truth.flight, MakeGaussHelmertProblem(truth.flight));
  EXPECT_THAT(accuracy.source, HasSubstr("flight.yaml"));
  EXPECT_LE((accuracy.sigma_ned_m - Vector3d(0.03, 0.03, 0.05)).norm(), 1e-12);
}

TEST(TrajectoryAccuracy, BadFilesAreNamed) {
  const std::string good = ", 0.01, 0.02, 0.03, 0.1, 0.1, 0.1, 0.004, 0.005, 0.006";
  const auto expect = [](const std::string& text, const std::string& what) {
    ExpectInvalidIn([&] { WithSigmaFile(text).Read(); }, what, "trajectory_sigma.txt");
  };
  expect(SigmaText(380000, 380010, good), "lies outside the standard deviations");
  expect(SigmaText(380000, 382000, ", 0.01, 0.02, 0.03, 0.1, 0.1, 0.1, 0.004, 0, 0.006"),
         "not positive");
  expect("1, 2, 3\n", "column");
}

// ---- Covariance of the trajectory over time ----------------------------------------------------

const std::string kGoodSigmas =
    ", 0.01, 0.01, 0.02, 0.1, 0.1, 0.1, 0.004, 0.004, 0.006";  // m, m/s, deg

// Returns a covariance whose errors are constant in each strip and independent between strips.
TrajectoryCovariance PerStrip(const std::vector<StripInterval>& strips) {
  TrajectoryCovariance covariance;
  for (std::size_t s = 0; s < strips.size(); ++s) {
    covariance.t_s.push_back(strips[s].t0_s);
    covariance.t_s.push_back(strips[s].t1_s);
    covariance.strip.insert(covariance.strip.end(), 2, static_cast<int>(s));
  }
  Eigen::Matrix<double, 6, 1> variance;
  variance << 1e-4, 1e-4, 4e-4, Vector3d(5e-9, 5e-9, 1e-8);
  const auto T = static_cast<Eigen::Index>(covariance.t_s.size());
  covariance.covariance.setZero(6 * T, 6 * T);
  for (Eigen::Index i = 0; i < T; ++i) {
    covariance.covariance.block<6, 6>(6 * i, 6 * i).diagonal() = variance;
    covariance.covariance.block<6, 6>(6 * i, 6 * (i ^ 1)).diagonal() = 0.999 * variance;
  }
  return covariance;
}

struct WithCovarianceFile : WithSigmaFile {
  explicit WithCovarianceFile(const std::string& text, bool noisy = false)
      : WithSigmaFile(SigmaText(380000, 382000, kGoodSigmas), noisy) {
    folder.Write("trajectory_covariance.txt", text);
  }
};

TEST(TrajectoryCovarianceFile, ReadsWhatItWrote) {
  const TrajectoryCovariance written = PerStrip(FindStrips(TruthFlight(false).flight));
  TempFolder folder;
  folder.Write("c.txt", FormatTrajectoryCovariance(written));
  const TrajectoryCovariance read = ReadTrajectoryCovariance(folder.path() / "c.txt");
  EXPECT_EQ(read.t_s, written.t_s);
  EXPECT_EQ(read.strip, written.strip);
  EXPECT_LE((read.covariance - written.covariance).norm(), 1e-8 * written.covariance.norm());
}

TEST(TrajectoryCovarianceFile, BadFilesAreNamed) {
  const std::string good = FormatTrajectoryCovariance(PerStrip({{"1", 10, 20}}));
  const auto expect = [](const std::string& text, const std::string& what) {
    TempFolder folder;
    folder.Write("c.txt", text);
    ExpectInvalidIn([&] { ReadTrajectoryCovariance(folder.path() / "c.txt"); }, what, "c.txt");
  };
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return text;
  };
  expect("", "no rows of numbers");
  expect("1 2 3\n", "column");
  expect(good.substr(0, good.rfind('\n', good.size() - 2) + 1), "rows are missing");
  expect(replaced("20 0 10 0", "20 0 11 0"),
         "the epochs do not follow the required order of the rows");
  expect(replaced("10 0 10 0 0.0001", "10 0 10 0 0"), "not positive");
  expect(replaced("10 0 10 0 0.0001", "10 -1 10 -1 0.0001"), "not an integer of at least 0");
}

TEST(TrajectoryAccuracy, ComesWithTheCovarianceThatCoversThePairs) {
  const std::vector<StripInterval> strips = FindStrips(TruthFlight(false).flight);
  ASSERT_GE(strips.size(), 2u);
  const TrajectoryAccuracy accuracy =
      WithCovarianceFile(FormatTrajectoryCovariance(PerStrip(strips))).Read();
  ASSERT_TRUE(accuracy.covariance);
  EXPECT_EQ(accuracy.source, "trajectory_covariance.txt");
  // A covariance of another part of the flight is ignored.
  const TrajectoryAccuracy other =
      WithCovarianceFile(FormatTrajectoryCovariance(PerStrip({{"1", 380100, 380110}}))).Read();
  EXPECT_FALSE(other.covariance);
  EXPECT_EQ(other.source, "trajectory_sigma.txt");
}

// Without a file of standard deviations, the covariance provides them.
TEST(TrajectoryAccuracy, ACovarianceAloneIsEnough) {
  const std::vector<StripInterval> strips = FindStrips(TruthFlight(false).flight);
  WithCovarianceFile flight(FormatTrajectoryCovariance(PerStrip(strips)));
  std::filesystem::remove(flight.folder.path() / "trajectory_sigma.txt");
  const TrajectoryAccuracy accuracy = flight.Read();
  ASSERT_TRUE(accuracy.covariance);
  EXPECT_LE((accuracy.sigma_ned_m - Vector3d(0.01, 0.01, 0.02)).norm(), 1e-9);
  EXPECT_LE((accuracy.sigma_rph_rad - Vector3d(7.1e-5, 7.1e-5, 1e-4)).norm(), 3e-6);
}

TEST(TrajectoryAccuracy, ComesFromTheFileThatIsNamed) {
  const std::string text =
      SigmaText(380000, 382000, ", 0.05, 0.05, 0.05, 0.1, 0.1, 0.1, 0.004, 0.005, 0.006");
  WithSigmaFile flight(SigmaText(380000, 382000, kGoodSigmas));
  flight.folder.Write("other.txt", text);
  flight.truth.flight.config.trajectory->sigma_file = "other.txt";
  const TrajectoryAccuracy accuracy = flight.Read();
  EXPECT_EQ(accuracy.source, "other.txt");
  EXPECT_LE((accuracy.sigma_ned_m - Vector3d::Constant(0.05)).norm(), 1e-12);
  // A covariance that does not cover the pairs is an error if the configuration names it.
  flight.folder.Write("covariance.txt",
                      FormatTrajectoryCovariance(PerStrip({{"1", 380100, 380110}})));
  flight.truth.flight.config.trajectory->sigma_file = "covariance.txt";
  ExpectInvalidIn([&] { flight.Read(); }, "does not cover the lidar data", "covariance.txt");
}

TEST(TrajectoryAccuracy, SeveralSmrmsgMustBeNamed) {
  WithSigmaFile flight(SigmaText(380000, 382000, kGoodSigmas));
  std::filesystem::remove(flight.folder.path() / "trajectory_sigma.txt");
  flight.folder.Write("smrmsg_1.out", "");
  flight.folder.Write("smrmsg_2.out", "");
  ExpectInvalidIn([&] { flight.Read(); }, "trajectory.sigma_file", "");
}

TEST(TrajectoryAccuracy, AnImpossibleCovarianceIsNamed) {
  TrajectoryCovariance covariance = PerStrip(FindStrips(TruthFlight(false).flight));
  covariance.covariance(0, 6) = covariance.covariance(6, 0) = 2e-4;
  ExpectInvalidIn([&] { WithCovarianceFile(FormatTrajectoryCovariance(covariance)).Read(); },
                  "not positive definite", "trajectory_covariance.txt");
}

TEST(TrajectoryAccuracy, ACovarianceOfAnotherRunIsNamed) {
  TrajectoryCovariance covariance = PerStrip(FindStrips(TruthFlight(false).flight));
  covariance.covariance *= 1.1;
  ExpectInvalidIn([&] { WithCovarianceFile(FormatTrajectoryCovariance(covariance)).Read(); },
                  "of different runs", "trajectory_covariance.txt");
}

// The error is constant in each of a few strips and has the stated size. The boresight absorbs
// about the mean of these constants.
TEST(GaussHelmertFlight, TheCovarianceOfTheTrajectoryIsThatOfTheAngles) {
  const std::vector<StripInterval> strips = FindStrips(TruthFlight(false).flight);
  WithCovarianceFile flight(FormatTrajectoryCovariance(PerStrip(strips)), true);
  flight.truth.Turn([&](double t_s) {
    const bool first = t_s<strips[0].t1_s + 5.0, last = t_s> strips.back().t0_s - 5.0;
    return Vector3d(Vector3d(7e-5, -7e-5, 1e-4) * (first ? 1.0 : last ? 0.3 : -1.0));
  });
  const GaussHelmertCalibration gh = CalibrateGaussHelmert(flight.truth.flight);
  EXPECT_EQ(gh.constant_rad2.norm(), 0.0);
  const double stated_rad = std::sqrt(5e-9);
  EXPECT_GT(gh.boresight.sigma_rad().x(), 0.3 * stated_rad);
  EXPECT_LT(gh.boresight.sigma_rad().x(), 1.1 * stated_rad);
  EXPECT_THAT(Words(gh.boresight.reasons),
              Contains(HasSubstr("according to trajectory_covariance.txt")));
}

// ---- Bad input ----------------------------------------------------------------------------------

TEST(GaussHelmertFlight, AnEpochOutsideTheTrajectoryIsNamed) {
  TruthFlight truth(false);
  std::vector<NavPoint> points = truth.flight.trajectory->points();
  points.resize(points.size() / 2);
  truth.flight.trajectory = Trajectory(points);
  try {
    MakeGaussHelmertProblem(truth.flight);
    FAIL() << "no InvalidInput";
  } catch (const InvalidInput& e) {
    EXPECT_THAT(e.what(), HasSubstr("is outside the trajectory (381000"));
  }
}

TEST(GaussHelmertFlight, MissingPartsAreNamed) {
  TruthFlight truth(false);
  truth.flight.config.estimate = {{"gnss_lever_arm", {}}};
  EXPECT_THROW(CalibrateGaussHelmert(truth.flight), InvalidConfig);
  truth.flight.config.estimate = {{"boresight", {}}, {"gnss_lever_arm", {}}};
  EXPECT_THAT(Words(CalibrateGaussHelmert(truth.flight).boresight.reasons),
              Contains(HasSubstr("gnss_lever_arm is not estimated")));
  truth.flight.trajectory.reset();
  EXPECT_THROW(CalibrateGaussHelmert(truth.flight), InvalidInput);
}

TEST(GaussHelmertFlight, AnInterruptEndsIt) {
  const TruthFlight truth(false);
  GaussHelmertFlightOptions options;
  options.interrupted = [] { return true; };
  EXPECT_THROW(CalibrateGaussHelmert(truth.flight, options), Interrupted);
}

// ---- Real and reference data --------------------------------------------------------------------

fs::path SharedData(const std::string& name) {
  return fs::path(DN_SHARED_DATA_DIR) / "data" / name;
}

TEST(GaussHelmertFlight, LiborCompatReproducesLibor) {
  const fs::path folder = SharedData("libor-check");
  if (!fs::exists(folder)) GTEST_SKIP() << "no reference data in " << folder;
  std::ifstream file(folder / "libor.json");
  const Json libor = Json::parse(file);
  const Flight flight = ReadFlight(folder, {.pairs = true, .trajectory = true});
  const GaussHelmertCalibration result = CalibrateGaussHelmert(flight);
  constexpr double kAngleDeg = 2e-5;  // libor computes in single precision
  constexpr double kRelative = 0.01;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    EXPECT_NEAR(result.boresight.angles_rad[k] * kDegPerRad,
                libor["boresight_deg"][i].get<double>(), kAngleDeg);
    const double sigma_deg = libor["sigma_scaled_deg"][i];
    EXPECT_NEAR((*result.boresight.sigma_scaled_rad)[k] * kDegPerRad, sigma_deg,
                kRelative * sigma_deg);
    EXPECT_TRUE(std::isfinite(result.boresight.sigma_rad()[k]));
    EXPECT_GT(result.boresight.sigma_rad()[k] * kDegPerRad, sigma_deg);
    for (std::size_t j = 0; j < 3; ++j) {
      EXPECT_NEAR(result.adjustment.correlation()(k, static_cast<Eigen::Index>(j)),
                  libor["correlation"][i][j].get<double>(), 1e-3);
    }
  }
  EXPECT_NEAR(result.adjustment.sigma0, libor["sigma0"].get<double>(), 1e-4);
  EXPECT_NEAR(result.adjustment.condition_number, libor["condition_number"].get<double>(), 0.01);
  EXPECT_NEAR(result.adjustment.residual_initial_m, libor["residual_initial_m"].get<double>(),
              1e-5);
  EXPECT_NEAR(result.adjustment.residual_final_m, libor["residual_final_m"].get<double>(), 1e-5);
  EXPECT_EQ(result.adjustment.outliers, libor["after_outlier_step"]["removed"].get<long>());
}

TEST(GaussHelmertFlight, TheReliableSigmaHoldsOnTheReferenceFlight) {
  const fs::path folder = SharedData("libor-check");
  if (!fs::exists(folder)) GTEST_SKIP() << "no reference data in " << folder;
  FlightConfig config = ReadFlightConfig(folder);
  config.gh = GhConfig();
  const GaussHelmertCalibration result =
      CalibrateGaussHelmert(ReadFlight(config, {.pairs = true, .trajectory = true}));
  const Vector3d truth = Vector3d(-0.133515781, 0.310373620, -0.389373981) * kRadPerDeg;
  const Vector3d error = BoresightError(result.boresight.angles_rad, truth);
  EXPECT_LT(error.dot(result.boresight.covariance_rad2.inverse() * error), 16.3);  // chi2_3, 0.1 %
  EXPECT_LT(result.boresight.sigma_rad().maxCoeff() * kDegPerRad, 0.002);
  EXPECT_EQ(result.boresight.verdict, Verdict::kCalibrated);
}

/// A point of a text strip: its epoch, laser vector and position.
struct StripPoint {
  double t_s = 0.0;
  Vector3d u_s, x_m;
};

std::vector<StripPoint> ReadStrip(const Flight& flight, const fs::path& file, std::size_t every) {
  const TextTable table = ReadTextTable(file, {7});
  const std::vector<MapPose> poses = flight.trajectory->ToMapPoses(flight.frame);
  std::vector<StripPoint> points;
  for (std::size_t i = 0; i < table.rows(); i += every) {
    const double* row = table.row(i);
    StripPoint point{row[0], Vector3d(row[4], row[5], row[6]), {}};
    if (!flight.trajectory->Covers(point.t_s)) continue;
    point.x_m =
        Georeference(InterpolatePose(poses, point.t_s), flight.config.lidar->mounting, point.u_s);
    points.push_back(point);
  }
  return points;
}

// This flight has no pairs, so the nearest points of the two lines replace them. The nearest points
// slide along the surfaces, so the angles are weak; the test shows only that the lines get closer.
TEST(GaussHelmertFlight, DrawsTheLinesOfARealFlightTogether) {
  const fs::path folder = SharedData("tent");
  if (!fs::exists(folder)) GTEST_SKIP() << "no real data in " << folder;
  Flight flight = ReadFlight(folder, {.trajectory = true});
  const std::vector<StripPoint> a = ReadStrip(flight, folder / "strips/line0.txt", 4);
  const std::vector<StripPoint> b = ReadStrip(flight, folder / "strips/line1.txt", 40);
  flight.pairs = PairData{{"nearest"}, {}};
  constexpr double kNearM = 0.25;
  for (const StripPoint& point : b) {
    const auto nearest = std::min_element(a.begin(), a.end(), [&](const auto& p, const auto& q) {
      return (p.x_m - point.x_m).squaredNorm() < (q.x_m - point.x_m).squaredNorm();
    });
    if ((nearest->x_m - point.x_m).norm() > kNearM) continue;
    LidarPair pair;
    pair.t_i_s = nearest->t_s;
    pair.t_j_s = point.t_s;
    pair.u_i_s = nearest->u_s;
    pair.u_j_s = point.u_s;
    flight.pairs->pairs.push_back(pair);
  }
  ASSERT_GT(flight.pairs->pairs.size(), 200u);
  flight.config.lidar->robust = RobustKind::kHuber;
  const GaussHelmertCalibration result = CalibrateGaussHelmert(flight);
  EXPECT_TRUE(result.adjustment.converged);
  EXPECT_LT(result.adjustment.residual_final_m, result.adjustment.residual_initial_m);
  EXPECT_LT(result.boresight.angles_rad.cwiseAbs().maxCoeff() * kDegPerRad, 1.0);
  EXPECT_EQ(result.diversity.strips, 2);
  EXPECT_FALSE(result.diversity.sufficient());
  EXPECT_THAT(Words(result.boresight.reasons), Contains(HasSubstr("2 strips")));
}

}  // namespace dn::adjustment_test
