#include <dn/error.h>
#include <dn/factors/point_to_point.h>
#include <dn/factors/point_to_point_between_nodes.h>
#include <gtest/gtest.h>

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
using testing::State;

/// Adds the value to the ranges of one scanner, and turns its boresight.
class ScannerRange final : public LidarEffect {
 public:
  explicit ScannerRange(int scanner) : scanner_(scanner) {}
  int components() const override { return 1; }
  void Correct(const Eigen::Ref<const VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    if (reading->scanner != scanner_) return;
    const Vector3d e = reading->u_s.normalized();
    const double range_m = reading->u_s.norm();
    reading->u_s -= value[0] * e;
    reading->J_u -= (value[0] / range_m) * (reading->J_u - e * (e.transpose() * reading->J_u));
    reading->J_u.col(column) = -e;
    reading->turn_b_rad.x() += 0.01 * value[0];
    reading->J_turn(0, column) += 0.01;
  }

 private:
  int scanner_;
};

class TwoScanners : public testing::CorrectedMotion {
 protected:
  const PreintegrationNoise noise_{0.1 * kRadPerDeg / 60.0, 0.01, 1e-6};
  const Matrix3d R_i_ = Matrix3d::Identity();
  const Matrix3d R_j_ = Exp(Vector3d(0.3, 1.2, -0.4)).toRotationMatrix();

  LidarEnd End(double t0_s, double t_s, double t1_s, const Vector3d& u_s, int scanner) const {
    LidarEnd end;
    end.tag_s = t_s + 0.002;
    end.partial = Preintegrate(imu_, t0_s, t_s, plain_, noise_);
    end.u_s = u_s;
    end.p_nominal_m = motion_.Pose(t0_s).p_mb;
    end.bridge = std::make_shared<IncrementConditioning>(
        motion_.frame, end.partial, Preintegrate(imu_, t0_s, t1_s, plain_, noise_));
    end.scanner = scanner;
    return end;
  }
  PreparedPair Pair() const {
    PreparedPair pair{End(1.0, 1.31, 2.0, {95.0, 10.0, 30.0}, 0),
                      End(4.0, 4.22, 5.0, {92.0, 0.0, -25.0}, 1), R_i_, 0.002,
                      Noise<3>::Sigma(1.0)};
    pair.R_bs_nominal_j = R_j_;
    return pair;
  }
  void AddNode(double t_s, std::vector<VectorXd>* x) const {
    const MapPose pose = motion_.Pose(t_s);
    x->insert(x->end(), {State(pose.q_mb), pose.p_mb, pose.v_m});
  }
  static void AddMounting(const Vector3d& theta, const Vector3d& arm_m, std::vector<VectorXd>* x) {
    x->insert(x->end(), {State(Exp(theta)), arm_m, VectorXd(VectorXd::Constant(1, 1e-3))});
  }
};

TEST_F(TwoScanners, JacobiansAgreeAtRandomStates) {
  const PointToPointBetweenNodes factor(
      motion_.frame, Pair(), {std::make_shared<ScannerRange>(0), std::make_shared<ScannerRange>(1)},
      {});
  for (unsigned seed = 0; seed < 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    std::vector<VectorXd> x;
    AddNode(1.0, &x);
    AddNode(4.0, &x);
    const double turn = seed % 2 == 0 ? 0.05 : 1.0;
    AddMounting(testing::RandomVector<3>(rng, turn), {0.14, -0.02, 0.21}, &x);
    AddMounting(testing::RandomVector<3>(rng, turn), {-1.1, 0.3, 0.1}, &x);
    x.insert(x.end(),
             {State(motion_.Attitude(2.0)), State(motion_.Attitude(5.0)),
              VectorXd(VectorXd::Constant(1, 0.02)), VectorXd(VectorXd::Constant(1, -0.03))});
    for (const std::size_t k : {0, 3, 12, 13}) {
      const Eigen::Quaterniond q(x[k].data());
      x[k] = State(q * Exp(testing::RandomVector<3>(rng, seed % 2 == 0 ? 1e-3 : 0.3)));
    }
    testing::ExpectFactorConsistent(factor, x);
  }
}

// With the same values for both mountings, the residual is that of one scanner.
TEST_F(TwoScanners, EqualMountingsGiveTheResidualOfOne) {
  PreparedPair pair = Pair();
  pair.R_bs_nominal_j = R_i_;
  const PointToPointBetweenNodes two(motion_.frame, pair, {}, {});
  pair.R_bs_nominal_j.reset();
  const PointToPointBetweenNodes one(motion_.frame, pair, {}, {});
  std::vector<VectorXd> x;
  AddNode(1.0, &x);
  AddNode(4.0, &x);
  AddMounting({0.01, 0.02, -0.03}, {0.14, -0.02, 0.21}, &x);
  std::vector<VectorXd> y = x;
  AddMounting({0.01, 0.02, -0.03}, {0.14, -0.02, 0.21}, &y);
  for (auto* blocks : {&x, &y}) {
    blocks->insert(blocks->end(), {State(motion_.Attitude(2.0)), State(motion_.Attitude(5.0))});
  }
  const auto residual = [](const FactorBase& factor, const std::vector<VectorXd>& blocks) {
    std::vector<const double*> data;
    for (const VectorXd& block : blocks) data.push_back(block.data());
    Vector3d r;
    EXPECT_TRUE(factor.Evaluate(data.data(), r.data(), nullptr));
    return r;
  };
  EXPECT_EQ(residual(one, x), residual(two, y));
}

TEST_F(TwoScanners, NeedTheBlocksOfBoth) {
  PreparedPair pair = Pair();
  pair.i.bridge = pair.j.bridge = nullptr;
  EXPECT_THROW(PointToPoint(motion_.frame, pair), InvalidInput);
  pair.R_bs_nominal_j = 2.0 * R_j_;
  EXPECT_THROW(PointToPointBetweenNodes(motion_.frame, pair, {}, {}), InvalidInput);
}

}  // namespace dn::factors_test
