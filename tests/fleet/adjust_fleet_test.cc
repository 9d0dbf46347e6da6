#include <dn/distributions.h>
#include <dn/error.h>
#include <dn/fleet/fleet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "fleet/toy_fleet.h"

namespace dn::fleet_test {

using ::testing::HasSubstr;
using ::testing::StartsWith;

// Tolerances relative to a sigma. In the joint adjustment, a constant boresight has steps of a
// thousandth of a sigma.
constexpr double kExact = 1e-6, kNearlyConstant = 1e-3;

ToyFleet MakeDifferent(std::size_t count, std::uint64_t seed) {
  ToyFleet fleet(seed);
  const VectorXd sensor = fleet.DrawSensor();
  for (std::size_t k = 0; k < count; ++k) {
    fleet.Fly(fleet.DrawDesign(), 0.5 * ToyFleet::kSigma * fleet.NormalVector(), sensor);
  }
  return fleet;
}

void ExpectJoint(const ToyFleet& fleet, const FleetResult& result, double walk_rad,
                 double tolerance) {
  const auto [mean, C] = fleet.AdjustJointly(walk_rad);
  const VectorXd sigma = C.diagonal().cwiseSqrt();
  const Vector3d difference = result.boresight.angles_rad - mean.head<3>();
  EXPECT_LT(difference.cwiseQuotient(sigma.head<3>()).norm(), tolerance);
  const Matrix3d expected = C.topLeftCorner<3, 3>();
  EXPECT_LT((result.boresight.covariance_rad2 - expected).norm(), tolerance * expected.norm());
  for (const EffectContribution& part : result.boresight.contributions) {
    if (part.effect != "lidar_lever_arm") continue;
    EXPECT_LT((part.estimate - mean.segment<3>(4)).cwiseQuotient(sigma.segment<3>(4)).norm(),
              tolerance);
    EXPECT_LT((part.sigma - sigma.segment<3>(4)).norm(), tolerance * sigma.segment<3>(4).norm());
  }
}

TEST(AdjustFleet, EqualsOneAdjustmentOfAllFlights) {
  const ToyFleet fleet = MakeDifferent(5, 11);
  ExpectJoint(fleet, AdjustFleet(fleet.flights, {}), 0.0, kNearlyConstant);
}

TEST(AdjustFleet, EqualsOneAdjustmentWithARandomWalk) {
  const ToyFleet fleet = MakeDifferent(5, 12);
  const double walk_rad = 0.7 * ToyFleet::kSigma;
  ExpectJoint(fleet, AdjustFleet(fleet.flights, {.walk_rad = walk_rad}), walk_rad, kExact);
}

TEST(AdjustFleet, AveragesWhatFlightsDoNotShare) {
  const FleetResult ten = AdjustFleet(MakeAlike(10, 21).flights, {});
  const ReducedFlight one = MakeAlike(1, 21).flights.front();
  const Vector3d pure = one.as_modelled.sigma_rad() / std::sqrt(10.0);
  EXPECT_LT((ten.boresight.as_modelled->sigma_rad() - pure).norm(), kExact * pure.norm());
  const Vector3d alone = one.covariance.diagonal().head<3>().cwiseSqrt();
  const Vector3d shared = ten.shared_covariance_rad2.diagonal().cwiseSqrt();
  for (int i = 0; i < 3; ++i) {
    EXPECT_LT(ten.boresight.sigma_rad()[i], alone[i]);
    EXPECT_GT(ten.boresight.sigma_rad()[i], alone[i] / std::sqrt(10.0));
    EXPECT_LT(shared[i], ten.boresight.sigma_rad()[i]);
    EXPECT_GT(shared[i], 0.3 * ten.boresight.sigma_rad()[i]);
  }
}

TEST(AdjustFleetManyRuns, HasCorrectCovariances) {
  constexpr int kFleets = 300;
  double nees = 0.0, modelled = 0.0;
  for (int k = 0; k < kFleets; ++k) {
    const FleetResult result =
        AdjustFleet(MakeAlike(4, 1000 + static_cast<std::uint64_t>(k)).flights, {});
    const Vector3d& error = result.boresight.angles_rad;
    nees += error.dot(result.boresight.covariance_rad2.inverse() * error);
    const Vector3d& pure = result.boresight.as_modelled->angles_rad;
    modelled += pure.dot(result.boresight.as_modelled->covariance_rad2.inverse() * pure);
  }
  const Interval band = ChiSquareInterval(0.99, 3.0 * kFleets);
  EXPECT_TRUE(band.Contains(nees / (3.0 * kFleets))) << nees / (3.0 * kFleets);
  EXPECT_GT(modelled, nees);  // the pure model leaves the shared effects out
}

TEST(AdjustFleetManyRuns, RaisesFewFalseAlarms) {
  constexpr int kFleets = 200;
  int alarms = 0;
  for (int k = 0; k < kFleets; ++k) {
    const auto seed = 5000 + static_cast<std::uint64_t>(k);
    alarms += AdjustFleet(MakeAlike(10, seed).flights, {}).stability.stable() ? 0 : 1;
  }
  EXPECT_LE(alarms, 5);  // 2 are expected
}

// The mount is put back 3 sigmas of one flight off, in each angle, after any of the flights.
TEST(AdjustFleet, NamesTheFlightOfARemount) {
  constexpr std::size_t kFleets = 100, kFlights = 10;
  std::size_t named = 0;
  for (std::size_t k = 0; k < kFleets; ++k) {
    SCOPED_TRACE(k);
    const std::size_t changed = 1 + k % (kFlights - 1);
    ToyFleet fleet(7000 + k), designer(1);
    const MatrixXd design = designer.DrawDesign();
    const VectorXd sensor = fleet.DrawSensor();
    const Vector3d sigma =
        MakeAlike(1, 1).flights.front().covariance.diagonal().head<3>().cwiseSqrt();
    for (std::size_t i = 0; i < kFlights; ++i) {
      fleet.Fly(design, i < changed ? Vector3d::Zero() : Vector3d(3.0 * sigma), sensor);
    }
    const FleetResult result = AdjustFleet(fleet.flights, {});
    const BoresightChange& change = result.stability.change;
    if (result.stability.stable() || change.flight != changed || change.single_flight) continue;
    ++named;
    EXPECT_EQ(result.boresight.verdict, Verdict::kContradicted);
    EXPECT_THAT(FleetReasons(result).front(),
                HasSubstr("changed before flight flight " + std::to_string(changed + 1)));
    EXPECT_LT((change.after.rad - 3.0 * sigma).cwiseQuotient(change.after.sigma_rad()).norm(), 6.0);
  }
  EXPECT_GE(named, 95u);
}

TEST(AdjustFleet, NamesASingleFlight) {
  ToyFleet fleet(31), designer(1);
  const MatrixXd design = designer.DrawDesign();
  const VectorXd sensor = fleet.DrawSensor();
  for (int k = 0; k < 8; ++k) {
    fleet.Fly(design, (k == 4 ? 1e-4 : 0.0) * Vector3d::Ones(), sensor);
  }
  const BoresightStability stability = AdjustFleet(fleet.flights, {}).stability;
  EXPECT_FALSE(stability.stable());
  EXPECT_TRUE(stability.change.single_flight);
  EXPECT_EQ(stability.change.flight, 4u);
  EXPECT_LT(stability.chi2_p_value, 1e-6);
}

TEST(AdjustFleet, EstimatesTheRandomWalk) {
  const double walk_rad = 3.0 * ToyFleet::kSigma;
  ToyFleet fleet(41);
  const VectorXd sensor = fleet.DrawSensor();
  Vector3d boresight = Vector3d::Zero();
  for (int k = 0; k < 40; ++k) {
    fleet.Fly(fleet.DrawDesign(), boresight, sensor);
    boresight += walk_rad * fleet.NormalVector();
  }
  const FleetResult result = AdjustFleet(fleet.flights, {.walk_estimated = true});
  EXPECT_NEAR(result.walk.sigma_rad, walk_rad, 0.3 * walk_rad);
  EXPECT_GT(result.walk.upper_rad, result.walk.sigma_rad);
  EXPECT_LT(result.walk.upper_rad, 1.6 * walk_rad);
  EXPECT_GT(result.walk.log_ratio, 20.0);
  EXPECT_TRUE(result.stability.stable()) << result.stability.p_value;
  const Vector3d error = result.next_walk.rad - boresight;
  EXPECT_LT(error.dot(result.next_walk.covariance_rad2.inverse() * error), 16.0);
  for (int i = 0; i < 3; ++i) EXPECT_GT(result.next_walk.sigma_rad()[i], result.walk.sigma_rad);
}

TEST(AdjustFleet, AConstantBoresightHasNoWalk) {
  const FleetResult result = AdjustFleet(MakeAlike(10, 51).flights, {.walk_estimated = true});
  EXPECT_LT(result.walk.sigma_rad, 0.5 * ToyFleet::kSigma);
  EXPECT_LT(result.walk.upper_rad, 2.0 * ToyFleet::kSigma);
  EXPECT_GE(result.next_limit.sigma_rad()[0], result.next_constant.sigma_rad()[0]);
}

// The prior of the boresight is in the result of each flight, but counts once.
TEST(AdjustFleet, CountsThePriorOfTheBoresightOnce) {
  ToyFleet fleet = MakeDifferent(3, 61);
  const FleetResult free = AdjustFleet(fleet.flights, {});
  const Vector3d mean = 2.0 * ToyFleet::kSigma * Vector3d::Ones();
  const Matrix3d P = Matrix3d::Identity() / std::pow(ToyFleet::kSigma, 2);
  for (ReducedFlight& flight : fleet.flights) {
    flight.prior_angles_rad = mean;
    flight.prior_sigma_rad = Vector3d::Constant(ToyFleet::kSigma);
    MatrixXd N = flight.covariance.inverse();
    VectorXd g = N * flight.mean;
    N.topLeftCorner<3, 3>() += P;
    g.head<3>() += P * mean;
    flight.covariance = N.inverse();
    flight.mean = flight.covariance * g;
  }
  const Matrix3d information = free.boresight.covariance_rad2.inverse();
  const Matrix3d C = (information + P).inverse();
  const Vector3d expected = C * (information * free.boresight.angles_rad + P * mean);
  const FleetResult result = AdjustFleet(fleet.flights, {});
  EXPECT_LT((result.boresight.covariance_rad2 - C).norm(), kExact * C.norm());
  EXPECT_LT((result.boresight.angles_rad - expected).norm(), kExact * expected.norm());
}

// A mixture of processes can leave an effect wider than its prior: the data then say nothing of it.
TEST(AdjustFleet, TakesAPosteriorWiderThanItsPrior) {
  ToyFleet fleet = MakeDifferent(3, 71);
  for (ReducedFlight& flight : fleet.flights) {
    flight.covariance(3, 3) = 1.1 * std::pow(ToyFleet::PriorSigma()[0], 2);
  }
  const FleetResult result = AdjustFleet(fleet.flights, {});
  for (const EffectContribution& part : result.boresight.contributions) {
    EXPECT_LE(part.sigma[0], (1.0 + kExact) * part.prior[0]) << part.effect;
  }
}

TEST(AdjustFleet, SharesEffectsOfAPlaceThere) {
  ToyFleet fleet = MakeAlike(3, 81);
  for (ReducedFlight& flight : fleet.flights) {
    flight.effects.back().effect = EffectId::kGravityDisturbance;
  }
  fleet.flights.back().origin.lat_rad = 0.01;  // 64 km away
  const FleetResult result = AdjustFleet(fleet.flights, {});
  int places = 0;
  for (const EffectContribution& part : result.boresight.contributions) {
    places += part.effect == "gravity_disturbance" ? 1 : 0;
  }
  EXPECT_EQ(places, 2);
}

template <class Call>
std::string ErrorText(const Call& call) {
  try {
    call();
  } catch (const InvalidConfig& error) {
    return error.what();
  }
  return "";
}

TEST(AdjustFleet, RefusesFlightsThatDoNotBelongTogether) {
  ToyFleet fleet = MakeAlike(2, 91);
  EXPECT_THAT(ErrorText([&] { AdjustFleet({fleet.flights.front()}, {}); }),
              HasSubstr("two flights"));
  EXPECT_THAT(ErrorText([&] { AdjustFleet(fleet.flights, {.unknowns = {"lidar_lever_arm"}}); }),
              StartsWith("across: 'lidar_lever_arm' is not under `estimate` of flight flight 1"));
  fleet.flights.back().prior_sigma_rad = fleet.flights.back().prior_angles_rad = Vector3d::Ones();
  EXPECT_THAT(ErrorText([&] { AdjustFleet(fleet.flights, {}); }), HasSubstr("different priors"));
  fleet.flights.back().mounting.lidar_lever_arm_b_m.x() = 0.1;
  EXPECT_THAT(ErrorText([&] { AdjustFleet(fleet.flights, {}); }),
              HasSubstr("flight 1 and flight 2 differ in lidar.lever_arm_m"));
}

}  // namespace dn::fleet_test
