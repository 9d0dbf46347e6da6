// The Gauss-Helmert adjustment equals a network with one pose per lidar epoch, a prior on each
// pose, and point-to-point factors only. Eliminating the poses gives its matrix S.

#include <dn/factors/point_to_point.h>
#include <dn/factors/prior.h>
#include <dn/fixed_trajectory/gauss_helmert.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>
#include <gtest/gtest.h>

#include "testing/strip_pairs.h"

namespace dn::adjustment_test {

constexpr double kEqual = 1e-8;  // relative; both converge quadratically to rounding

struct PoseNetwork {
  Network net;
  Block<LeftRotation> boresight;
  Block<Vec<3>> lever_arm;
  Block<Vec<1>> time_offset;

  explicit PoseNetwork(const GaussHelmertProblem& problem) {
    boresight = net.AddLeftRotation("boresight", Exp(problem.boresight_rad));
    lever_arm = net.AddVector<3>("lever_arm", problem.lever_arm_b_m);
    time_offset = net.AddVector<1>("time_offset", Eigen::Matrix<double, 1, 1>::Zero());
    net.Hold(lever_arm);
    net.Hold(time_offset);
    const LocalFrame frame(Geodetic{0.8, 0.1, 0.0});
    for (std::size_t k = 0; k < problem.pairs.size(); ++k) {
      const GaussHelmertPair& pair = problem.pairs[k];
      const std::string name = std::to_string(k);
      const Node i = AddNode(pair.i, "i/" + name);
      const Node j = AddNode(pair.j, "j/" + name);
      const PointToPoint edge(frame, {AtNode(pair.i), AtNode(pair.j), Eigen::Matrix3d::Identity(),
                                      0.0, Noise<3>::Covariance(pair.covariance_m2)});
      net.Add(edge, i.q, i.p, i.v, j.q, j.p, j.v, boresight, lever_arm, time_offset);
    }
  }

 private:
  struct Node {
    Block<Rotation> q;
    Block<Vec<3>> p, v;
  };

  /// Adds a pose whose prior has the noise of the end; its velocity is constant.
  Node AddNode(const GaussHelmertEnd& end, const std::string& name) {
    Node node{net.AddRotation("q/" + name, end.q_mb), net.AddVector<3>("p/" + name, end.p_mb),
              net.AddVector<3>("v/" + name, Eigen::Vector3d::Zero())};
    net.Hold(node.v);
    const Eigen::Matrix3d L = end.q_mn.toRotationMatrix() * end.sigma_ned_m.asDiagonal();
    const Eigen::Vector3d down_b = end.q_mb.conjugate() * (end.q_mn * Eigen::Vector3d::UnitZ());
    const Eigen::Matrix3d F = BodyFromEulerRates(down_b) * end.sigma_rph_rad.asDiagonal();
    net.Add(PriorVector<3>(end.p_mb, Noise<3>::Covariance(L * L.transpose())), node.p);
    net.Add(PriorRotation(end.q_mb, Noise<3>::Covariance(F * F.transpose())), node.q);
    return node;
  }

  static LidarEnd AtNode(const GaussHelmertEnd& end) {
    LidarEnd lidar;  // no increments: the epoch is that of the node
    lidar.partial.t_begin_s = lidar.partial.t_end_s = end.t_s;
    lidar.u_s = end.u_b;
    lidar.p_nominal_m = end.p_mb;
    return lidar;
  }
};

class GaussHelmertNetwork : public ::testing::TestWithParam<unsigned> {};

TEST_P(GaussHelmertNetwork, EqualsTheNetworkWithPosePriors) {
  testing::StripPairOptions options;
  options.count = 80;
  options.seed = GetParam();
  // The errors of the trajectory are so large that their second order counts: only the rigorous
  // iteration reaches this solution.
  options.sigma_rph_rad = Eigen::Vector3d(1e-3, 2e-3, 5e-3);
  options.sigma_ned_m = Eigen::Vector3d(0.1, 0.15, 0.3);
  GaussHelmertProblem problem = testing::MakeStripPairs(options);
  std::mt19937 rng(GetParam());
  testing::Disturb(&problem, testing::WhiteErrors(rng), options.sigma_p_m, rng);

  GaussHelmertOptions gh_options;
  gh_options.outlier_medians = 0.0;
  gh_options.tolerance_rad = 1e-13;
  const GaussHelmertResult gh = AdjustGaussHelmert(problem, gh_options);
  ASSERT_TRUE(gh.converged);

  PoseNetwork network(problem);
  SolveOptions solve_options;
  solve_options.function_tolerance = 1e-16;
  solve_options.gradient_tolerance = 1e-16;
  solve_options.parameter_tolerance = 1e-16;
  solve_options.initial_trust_region_radius = 1e6;  // almost Gauss-Newton
  const SolveSummary summary = Solve(network.net, solve_options);
  ASSERT_GT(summary.iterations, 0) << summary.message;
  const Marginals marginals(network.net);

  const Eigen::Vector3d theta = Log(network.net.Value(network.boresight));
  EXPECT_LE((gh.boresight_rad - theta).norm(), kEqual * theta.norm());
  const Eigen::Matrix3d N = marginals.ReducedNormal(network.boresight.id);
  EXPECT_LE((gh.normal - N).norm(), kEqual * N.norm());
  EXPECT_NEAR(gh.chi2, 2.0 * summary.final_cost, kEqual * gh.chi2);
  // The corrected observations equal the adjusted poses.
  const GaussHelmertEnd& end = problem.pairs[7].j;
  const Eigen::Vector3d p = end.p_mb + gh.corrections[7].segment<3>(6);
  const Eigen::Vector3d p_network = network.net.Value(Block<Vec<3>>{network.net.Find("p/j/7")});
  EXPECT_LE((p - p_network).norm(), 1e-8);
}

INSTANTIATE_TEST_SUITE_P(Seeds, GaussHelmertNetwork, ::testing::Values(1u, 2u, 3u, 4u, 5u));

}  // namespace dn::adjustment_test
