#include <ceres/covariance.h>
#include <ceres/solver.h>
#include <dn/builder/flight_network.h>
#include <dn/builder/flight_nodes.h>
#include <dn/builder/node_grid.h>
#include <dn/ceres.h>
#include <dn/solvers/eliminate.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <set>
#include <string>
#include <vector>

#include "testing/short_flights.h"

namespace dn::builder_test {

SimulatedFlight Fly(std::uint64_t seed) {
  SimulateOptions options;
  options.seed = seed;
  return Simulate(testing::DroneScenario(), options);
}

/// Returns the network of a flight at its truth, with pairs.
FlightNetwork AtTruth(const SimulatedFlight& sim) {
  const Flight& flight = sim.flight;
  const TimeInterval span = NetworkSpan(flight, true);
  const std::vector<double> times = NodeTimes(*flight.imu, span, GnssTimes(flight, span), {}, {});
  InitialStates initial;
  for (const double t_s : times) initial.nodes.push_back(sim.truth->Pose(t_s));
  FlightNetwork network(flight, times, initial);
  network.net().SetValue(network.calibration().boresight(), Exp(sim.boresight_rad));
  network.AddPairs(flight.pairs->pairs);
  return network;
}

Eigen::Matrix3d Information(const Network& net, const std::string& name) {
  return MarginalCovariance(net, net.Find<LeftRotation>(name)).inverse();
}

/// Inertial, GNSS, bias and lidar factors in a program that has only Ceres and its own numbers.
class PlainCeresProgram : public ::testing::Test {
 protected:
  PlainCeresProgram() {
    const Network& net = flight_.net();
    for (BlockId b = 0; b < net.num_blocks(); ++b) numbers_.push_back(net.Value(b));
    for (FactorId id = 0; id < net.num_factors(); ++id) {
      const FactorRecord& record = net.factor(id);
      if (!record.active) continue;
      groups_.insert(net.group(id).name);
      std::vector<double*> x;
      for (const BlockId b : record.blocks) {
        x.push_back(Numbers(b));
        if (problem_.HasParameterBlock(x.back())) continue;
        const BlockKind& kind = net.block(b).kind;
        problem_.AddParameterBlock(x.back(), kind.stored_size, MakeCeresManifold(kind).release());
        if (net.block(b).held) problem_.SetParameterBlockConstant(x.back());
      }
      problem_.AddResidualBlock(MakeCostFunction(record.factor).release(), nullptr, x);
    }
  }

  double* Numbers(BlockId b) { return numbers_[static_cast<std::size_t>(b)].data(); }

  SimulatedFlight sim_ = Fly(7);
  FlightNetwork flight_ = AtTruth(sim_);
  std::vector<Eigen::VectorXd> numbers_;
  ceres::Problem problem_;
  std::set<std::string> groups_;
};

TEST_F(PlainCeresProgram, SolvesAFlight) {
  for (const char* group : {"inertial", "gnss position", "bias process", "lidar p2p"}) {
    EXPECT_TRUE(groups_.contains(group)) << group;
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  options.initial_trust_region_radius = 1e13;
  options.function_tolerance = 1e-14;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem_, &summary);
  ASSERT_TRUE(summary.IsSolutionUsable()) << summary.message;
  ASSERT_TRUE(Solve(flight_.net(), {.initial_trust_region_radius = 1e13}).converged);
  const Marginals expected(flight_.net()), got(problem_);
  for (const BlockId b :
       {flight_.calibration().boresight().id, flight_.nodes()[50].q_mb.id,
        flight_.nodes()[50].p_mb.id, flight_.trajectory().gyro_bias()[0].blocks[0].id}) {
    Eigen::Vector3d difference;
    Minus(flight_.net().block(b).kind, Numbers(b), flight_.net().Value(b).data(),
          difference.data());
    const Eigen::VectorXd sigma = expected.Covariance(b).diagonal().cwiseSqrt();
    EXPECT_LE(difference.cwiseQuotient(sigma).norm(), 1e-3) << flight_.net().block(b).name;
    EXPECT_LE((got.Covariance(Numbers(b)) - expected.Covariance(b)).norm(),
              1e-4 * expected.Covariance(b).norm())
        << flight_.net().block(b).name;
  }
}

TEST_F(PlainCeresProgram, HasTheCovarianceOfCeres) {
  const double* boresight = Numbers(flight_.calibration().boresight().id);
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::SPARSE_QR;
  options.sparse_linear_algebra_library_type = ceres::SUITE_SPARSE;
  ceres::Covariance reference(options);
  std::vector<std::pair<const double*, const double*>> pair{{boresight, boresight}};
  ASSERT_TRUE(reference.Compute(pair, &problem_));
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> expected;
  ASSERT_TRUE(reference.GetCovarianceBlockInTangentSpace(boresight, boresight, expected.data()));
  EXPECT_LE((Marginals(problem_).Covariance(boresight) - expected).norm(), 1e-6 * expected.norm());
}

// The information of two flights on their common boresight adds up.
TEST(ComposedFlights, ShareABoresight) {
  const SimulatedFlight monday = Fly(7), tuesday = Fly(8);
  const FlightNetwork first = AtTruth(monday), second = AtTruth(tuesday);
  Network both;
  both.Append(first.net(), "monday/", {"boresight"});
  const Network::Appended added = both.Append(second.net(), "tuesday/", {"boresight"});
  EXPECT_EQ(both.num_blocks(), first.net().num_blocks() + second.net().num_blocks() - 1);
  EXPECT_EQ(both.Value(added.Handle(second.nodes()[3].p_mb)),
            second.net().Value(second.nodes()[3].p_mb));
  const Eigen::Matrix3d sum =
      Information(first.net(), "boresight") + Information(second.net(), "boresight");
  EXPECT_LE((Information(both, "boresight") - sum).norm(), 1e-5 * sum.norm());
}

// A flight becomes a prior of its boresight in the next one.
TEST(ComposedFlights, EliminateAFinishedFlight) {
  const SimulatedFlight monday = Fly(7), tuesday = Fly(8);
  const FlightNetwork first = AtTruth(monday), second = AtTruth(tuesday);
  Network finished = first.net();
  std::vector<BlockId> all_but_boresight;
  for (BlockId b = 0; b < finished.num_blocks(); ++b) {
    if (b != first.calibration().boresight().id) all_but_boresight.push_back(b);
  }
  const Elimination elimination = Eliminate(&finished, all_but_boresight, {.name = "monday"});
  EXPECT_EQ(elimination.neighbours, std::vector<BlockId>{first.calibration().boresight().id});
  Network net = second.net();
  net.Append(finished, "", {"boresight"});
  const Eigen::Matrix3d sum =
      Information(first.net(), "boresight") + Information(second.net(), "boresight");
  EXPECT_LE((Information(net, "boresight") - sum).norm(), 1e-5 * sum.norm());
}

}  // namespace dn::builder_test
