#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/adjustment/trajectory_covariance.h>
#include <dn/adjustment/words.h>
#include <dn/diagnosis/result_files.h>
#include <dn/geo/trajectory_covariance.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "testing/short_flights.h"
#include "testing/temp_folder.h"
#include "testing/torsion.h"

namespace dn::diagnosis_test {

using testing::AircraftScenario;
using ::testing::AnyOf;
using ::testing::Contains;
using testing::DroneScenario;
using testing::Fly;
using ::testing::HasSubstr;
using testing::TempFolder;

/// A flight calibrated on its true trajectory.
Flight OnTruth(Flight flight) {
  flight.trajectory = flight.reference;
  flight.config.trajectory = TrajectoryConfig();
  return flight;
}

Flight OnTruth(const Scenario& scenario, std::uint64_t seed) {
  return OnTruth(Fly(scenario, seed).flight);
}

/// Files with which the smoother states its own accuracy.
enum class Stated { kNothing, kSigmaFile, kCovariance };

/// A flight calibrated on the trajectory of its own inertial and GNSS data.
struct Smoothed {
  TempFolder folder;
  Flight flight;

  Smoothed(const Scenario& scenario, std::uint64_t seed, Stated stated)
      : flight(Fly(scenario, seed).flight) {
    AdjustOptions without_lidar;
    without_lidar.with_pairs = false;
    const Solution smoothed(flight, without_lidar);
    TrajectoryNotes notes;
    notes.velocity_from_file = true;
    if (stated != Stated::kNothing) {
      folder.Write("trajectory_sigma.txt", FormatTrajectorySigma(smoothed.CheckedSigmas()));
    }
    if (stated == Stated::kCovariance) {
      folder.Write("trajectory_covariance.txt",
                   FormatTrajectoryCovariance(smoothed.PoseCovariance(FindStrips(flight))));
    }
    flight.trajectory = Trajectory(DenseTrajectory(smoothed.network(), 0.01), notes);
    flight.config.trajectory = TrajectoryConfig();
    flight.config.folder = folder.path();
  }
};

struct CheckedCalibration : GaussHelmertCalibration {
  ModelCheck model_check;

  explicit CheckedCalibration(const Flight& flight)
      : GaussHelmertCalibration(CalibrateGaussHelmert(flight)),
        model_check(AssessModel(flight, this)) {}
};

std::vector<std::string> NamedEffects(const ModelCheck& check) {
  std::vector<std::string> names;
  for (const EffectCheck& effect : check.effects) {
    names.push_back(effect.name);
    names.insert(names.end(), effect.inseparable_from.begin(), effect.inseparable_from.end());
  }
  return names;
}

std::string Words(const GaussHelmertCalibration& calibration) {
  std::string words = Word(calibration.boresight.verdict);
  for (const std::string& reason : dn::Words(calibration.boresight.reasons))
    words += "\n  " + reason;
  return words;
}

// ---- Flights without a fault --------------------------------------------------------------------

TEST(GaussHelmertCheckManyRuns, ATrueTrajectoryIsCalibrated) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (const Scenario& scenario : {AircraftScenario(), DroneScenario()}) {
      const CheckedCalibration gh(OnTruth(scenario, seed));
      EXPECT_EQ(gh.boresight.verdict, Verdict::kCalibrated) << Words(gh);
      EXPECT_TRUE(gh.model_check.effects.empty()) << Words(gh);
    }
  }
}

class OfASmoother : public ::testing::TestWithParam<Stated> {};

// The errors of a smoothed trajectory are those of real adjustments: time-correlated, with an
// unknown correlation time.
TEST_P(OfASmoother, ATrajectoryIsNotContradicted) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    for (const Scenario& scenario : {AircraftScenario(), DroneScenario()}) {
      const Smoothed smoothed(scenario, seed, GetParam());
      const CheckedCalibration gh(smoothed.flight);
      EXPECT_THAT(gh.boresight.verdict, AnyOf(Verdict::kCalibrated, Verdict::kAbsorbed))
          << Words(gh);
      EXPECT_TRUE(gh.model_check.effects.empty()) << Words(gh);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(ManyRuns, OfASmoother,
                         ::testing::Values(Stated::kNothing, Stated::kSigmaFile,
                                           Stated::kCovariance));

TEST(GaussHelmertCheck, ATorsionOfTheScannerIsUnmodelledAndContradicts) {
  const CheckedCalibration gh(OnTruth(testing::FlyWithTorsion(AircraftScenario(), 0.1).flight));
  ASSERT_EQ(gh.model_check.discrepancies.size(), 1U);
  EXPECT_EQ(gh.model_check.discrepancies.front().name, "laser vectors by scan angle");
  EXPECT_LT(gh.model_check.discrepancies.front().p_value, 1e-4);
  EXPECT_EQ(gh.boresight.verdict, Verdict::kContradicted) << Words(gh);
  EXPECT_THAT(Words(gh), HasSubstr("a discrepancy that no known effect explains"));
}

// ---- Faults -------------------------------------------------------------------------------------

struct Fault {
  std::string effect;
  std::function<void(Flight*)> apply;
  const char* words;
  bool undetectable_in_aircraft = false;  ///< undetectable next to position errors of 3 cm
};

std::ostream& operator<<(std::ostream& out, const Fault& fault) { return out << fault.words; }

std::function<void(Flight*)> Late(double by_s) {
  return [by_s](Flight* flight) {
    for (LidarPair& pair : flight->pairs->pairs) {
      pair.t_i_s += by_s;
      pair.t_j_s += by_s;
    }
  };
}

std::function<void(Flight*)> Longer(double by_m) {
  return [by_m](Flight* flight) {
    for (LidarPair& pair : flight->pairs->pairs) {
      pair.u_i_s += by_m * pair.u_i_s.normalized();
      pair.u_j_s += by_m * pair.u_j_s.normalized();
    }
  };
}

void Mirror(Flight* flight) { flight->config.lidar->mounting.lever_arm_b_m *= -1.0; }

class GaussHelmertFault : public ::testing::TestWithParam<Fault> {};

void ExpectContradictedAndNamed(const Flight& flight, const std::string& effect) {
  const CheckedCalibration gh(flight);
  EXPECT_EQ(gh.boresight.verdict, Verdict::kContradicted) << Words(gh);
  EXPECT_THAT(NamedEffects(gh.model_check), Contains(effect)) << Words(gh);
}

TEST_P(GaussHelmertFault, OnATrueTrajectoryIsContradictedAndNamed) {
  for (const Scenario& scenario : {AircraftScenario(), DroneScenario()}) {
    if (GetParam().undetectable_in_aircraft && scenario.name == "aircraft") continue;
    SCOPED_TRACE(scenario.name);
    Flight flight = OnTruth(scenario, 3);
    GetParam().apply(&flight);
    ExpectContradictedAndNamed(flight, GetParam().effect);
  }
}

TEST_P(GaussHelmertFault, OnASmoothedTrajectoryIsContradictedAndNamed) {
  for (const Scenario& scenario : {AircraftScenario(), DroneScenario()}) {
    SCOPED_TRACE(scenario.name);
    Smoothed smoothed(scenario, 3, Stated::kSigmaFile);
    GetParam().apply(&smoothed.flight);
    ExpectContradictedAndNamed(smoothed.flight, GetParam().effect);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Faults, GaussHelmertFault,
    ::testing::Values(Fault{"lidar_time_offset", Late(0.010), "10 ms late"},
                      Fault{"lidar_time_offset", Late(0.050), "50 ms late"},
                      Fault{"lidar_lever_arm", Mirror, "lever arm mirrored", true},
                      Fault{"lidar_range_offset", Longer(0.5), "ranges 0.5 m longer"}));

// ---- Boresights larger than any mount -----------------------------------------------------------

TEST(GaussHelmertCheck, ASigmaAboveHalfADegreeIsNotObservable) {
  Flight flight = OnTruth(DroneScenario(), 1);
  flight.config.trajectory->sigma_y_rad = 0.6 * kRadPerDeg;
  const CheckedCalibration gh(flight);
  EXPECT_GT(gh.boresight.sigma_rad().z(), 0.5 * kRadPerDeg);
  EXPECT_LT(gh.boresight.sigma_apriori_rad->z(), 0.5 * kRadPerDeg);
  EXPECT_EQ(gh.boresight.verdict, Verdict::kNotObservable) << Words(gh);
  EXPECT_THAT(Words(gh.boresight.reasons), Contains(HasSubstr("yaw exceeds 0.5 deg")));
}

TEST(GaussHelmertCheck, AMisreadTrajectoryIsNotCalibrated) {
  const auto changed = [](const std::function<void(NavPoint*)>& change) {
    Flight flight = OnTruth(DroneScenario(), 1);
    std::vector<NavPoint> points = flight.trajectory->points();
    for (NavPoint& point : points) change(&point);
    flight.trajectory = Trajectory(points, flight.trajectory->notes());
    return CheckedCalibration(flight);
  };
  const CheckedCalibration heights = changed([](NavPoint* point) { point->position.h_m *= -1.0; });
  EXPECT_THAT(heights.boresight.verdict, AnyOf(Verdict::kNotObservable, Verdict::kContradicted))
      << Words(heights);
  const CheckedCalibration columns =
      changed([](NavPoint* point) { std::swap(point->q_nb.x(), point->q_nb.y()); });
  EXPECT_THAT(columns.boresight.verdict, AnyOf(Verdict::kNotObservable, Verdict::kContradicted))
      << Words(columns);
}

}  // namespace dn::diagnosis_test
