#include <dn/error.h>
#include <dn/factors/node_bridge.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/point_to_point_between_nodes.h>
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "factors/corrected_motion.h"
#include "testing/earth_motion.h"
#include "testing/factor_consistency.h"
#include "testing/random.h"

namespace dn::factors_test {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix9 = IncrementConditioning::Matrix9;
using testing::EarthMotion;
using testing::State;

// Large enough that the conditional covariance is far above the floor of the positions.
const PreintegrationNoise kStrongNoise{5.0 * kRadPerDeg / 60.0, 0.05, 1e-6};

class Bridge : public testing::CorrectedMotion {
 protected:
  Preintegrated Increments(double t0_s, double t1_s, const ImuCorrection& correction) const {
    return Preintegrate(imu_, t0_s, t1_s, correction, kStrongNoise);
  }
  IncrementConditioning Make(double t0_s, double t_s, double t1_s,
                             const ImuCorrection& correction) const {
    return {motion_.frame, Increments(t0_s, t_s, correction), Increments(t0_s, t1_s, correction)};
  }
  LidarEnd End(double t0_s, double t_s, double t1_s, const Vector3d& u_s,
               const ImuCorrection& correction) const {
    LidarEnd end;
    end.partial = Increments(t0_s, t_s, correction);
    end.u_s = u_s;
    end.p_nominal_m = motion_.Pose(t0_s).p_mb;
    end.bridge = std::make_shared<IncrementConditioning>(Make(t0_s, t_s, t1_s, correction));
    return end;
  }
  void AddNode(double t_s, std::vector<VectorXd>* x) const {
    const MapPose pose = motion_.Pose(t_s);
    x->insert(x->end(), {State(pose.q_mb), pose.p_mb, pose.v_m});
  }
};

// The white noise of a gyro integrates to a Wiener process, whose value at the next node is
// observed.
TEST_F(Bridge, CovarianceIsThatOfABrownianBridge) {
  const double white = kStrongNoise.gyro_white_rad_per_sqrt_s;
  for (const double t : {0.1, 0.5, 0.9}) {
    const Matrix9 covariance = Make(1.0, 1.0 + t, 2.0, plain_).covariance();
    const Matrix3d expected = white * white * t * (1.0 - t) * Matrix3d::Identity();
    EXPECT_LE((covariance.topRows(3).leftCols(3) - expected).norm(), 1e-3 * expected.norm()) << t;
    EXPECT_GE(covariance.selfadjointView<Eigen::Lower>().eigenvalues()[0], 0.0);
  }
  const Matrix9 at_the_end = Make(1.0, 2.0, 2.0, plain_).covariance();
  EXPECT_LE(at_the_end.topRows(3).leftCols(3).norm(), 1e-12 * white * white);
}

// With the truth at both nodes, the errors of the corrected increments must agree with the
// conditional covariance. The errors of the plain increments must agree with their own covariance.
// The test uses many draws of white noise.
TEST_F(Bridge, CorrectionTakesTheNoiseThatTheNodesTell) {
  constexpr int kDraws = 400;
  const Preintegrated truth = Increments(1.0, 1.4, {});
  const Eigen::Quaterniond q = motion_.Attitude(1.0), q_after = motion_.Attitude(2.0);
  Vector3d before = Vector3d::Zero(), after = Vector3d::Zero();
  for (unsigned seed = 0; seed < kDraws; ++seed) {
    std::mt19937 rng(seed);
    std::normal_distribution<double> normal;
    ImuData noisy = imu_;
    const double per_sample = kStrongNoise.gyro_white_rad_per_sqrt_s * std::sqrt(200.0);
    for (ImuSample& sample : noisy.samples) {
      sample.w_ib_b_radps +=
          plain_.gyro_bias_radps + per_sample * Vector3d(normal(rng), normal(rng), normal(rng));
      sample.f_b_mps2 += plain_.accel_bias_mps2;
    }
    const Preintegrated partial = Preintegrate(noisy, 1.0, 1.4, plain_, kStrongNoise);
    const IncrementConditioning bridge(motion_.frame, partial,
                                       Preintegrate(noisy, 1.0, 2.0, plain_, kStrongNoise));
    const Vector3d moved = bridge.At(q, q_after, VectorXd()).increments.head<3>();
    before += Log(partial.delta_q.conjugate() * truth.delta_q).cwiseAbs2();
    after += Log((partial.delta_q * Exp(moved)).conjugate() * truth.delta_q).cwiseAbs2();
  }
  const Matrix9 predicted = Make(1.0, 1.4, 2.0, plain_).covariance();
  const double bound = 4.0 * std::sqrt(2.0 / kDraws);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(after[axis] / kDraws / predicted(axis, axis), 1.0, bound) << "axis " << axis;
    EXPECT_NEAR(before[axis] / kDraws / truth.covariance(axis, axis), 1.0, bound);
  }
}

TEST_F(Bridge, ReachesNotBeyondTheNodeAfter) {
  const IncrementConditioning bridge = Make(1.0, 2.2, 2.0, plain_);
  EXPECT_EQ(bridge.covariance(), Increments(1.0, 2.2, plain_).covariance);
  const IncrementConditioning::Correction at =
      bridge.At(motion_.Attitude(1.1), motion_.Attitude(2.0), VectorXd());
  EXPECT_EQ(at.increments.norm() + at.J_q.norm() + at.J_q_after.norm(), 0.0);
}

TEST_F(Bridge, RejectsIncrementsOfAnotherNode) {
  const Preintegrated partial = Increments(1.1, 1.3, plain_);
  EXPECT_THROW(IncrementConditioning(motion_.frame, partial, Increments(1.0, 2.0, plain_)),
               InvalidInput);
  EXPECT_THROW(IncrementConditioning(motion_.frame, partial, Increments(1.1, 2.0, scaled_)),
               InvalidInput);
}

TEST_F(Bridge, PlainPairWantsNoBridges) {
  EXPECT_THROW(PointToPoint(motion_.frame, {End(1.0, 1.3, 2.0, {900.0, 0.0, 0.0}, plain_),
                                            End(4.0, 4.2, 5.0, {900.0, 0.0, 0.0}, plain_),
                                            Matrix3d::Identity(), 0.0, Noise<3>::Sigma(1.0)}),
               InvalidInput);
}

class BridgedEnds : public Bridge, public ::testing::WithParamInterface<std::pair<bool, bool>> {};

TEST_P(BridgedEnds, JacobiansAgreeAtRandomStates) {
  const auto [at_i, at_j] = GetParam();
  const std::vector<GravitationBasis> attraction{Eigen::Matrix<double, 3, 2>::Ones()};
  LidarEnd i = End(1.0, 1.31, 2.0, {950.0, 10.0, 300.0}, scaled_);
  LidarEnd j = End(4.0, 4.22, 5.0, {920.0, 0.0, -250.0}, scaled_);
  if (!at_i) i.bridge = nullptr;
  if (!at_j) j.bridge = nullptr;
  i.tag_s = 1.312;
  j.tag_s = 4.222;
  const PointToPointBetweenNodes factor(
      motion_.frame, {i, j, Matrix3d::Identity(), 0.0, Noise<3>::Sigma(1.0)}, {}, attraction);
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    std::vector<VectorXd> x;
    AddNode(1.0, &x);
    AddNode(4.0, &x);
    x.insert(x.end(), {State(Exp(Vector3d(0.04, -0.02, 0.06))), Vector3d(0.14, -0.02, 0.21),
                       VectorXd(VectorXd::Constant(1, 1e-3))});
    if (at_i) x.push_back(State(motion_.Attitude(2.0)));
    if (at_j) x.push_back(State(motion_.Attitude(5.0)));
    x.insert(x.end(), {testing::RandomVector<3>(rng, 1e-2), VectorXd(VectorXd::Constant(2, 1e-3))});
    for (std::size_t k = 0; k < x.size(); ++k) {
      if (x[k].size() == 4) {
        const Eigen::Quaterniond q(x[k].data());
        x[k] = State(q * Exp(testing::RandomVector<3>(rng, seed % 2 == 0 ? 1e-3 : 0.3)));
      } else if (x[k].size() == 3 && k < 6) {
        x[k] += testing::RandomVector<3>(rng, 0.5);
      }
    }
    testing::ExpectFactorConsistent(factor, x);
  }
}

INSTANTIATE_TEST_SUITE_P(IncrementConditioning, BridgedEnds,
                         ::testing::Values(std::pair{true, true}, std::pair{true, false},
                                           std::pair{false, true}),
                         [](const auto& tested) {
                           return std::string(tested.param.first ? "i" : "") +
                                  (tested.param.second ? "j" : "");
                         });

}  // namespace dn::factors_test
