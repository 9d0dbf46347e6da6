#include <dn/error.h>
#include <dn/factors/point_to_control.h>
#include <gtest/gtest.h>

#include <limits>
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
using testing::EarthMotion;
using testing::State;

const PreintegrationNoise kNoise{5.0 * kRadPerDeg / 60.0, 0.05, 1e-6};
constexpr double kTagS = 1.312, kEndS = 1.31;

/// The residual of PointToControl by the formulas of LidarPoint, without bridge and effects.
struct PlainControl {
  const FactorBase& factor;
  LidarPoint point;
  PreparedControl control;

  const std::vector<BlockKind>& block_kinds() const { return factor.block_kinds(); }
  int residual_size() const { return factor.residual_size(); }

  template <class T>
  bool Residual(T const* const* x, T* r) const {
    using Vec3 = Eigen::Matrix<T, 3, 1>;
    using Quat = Eigen::Quaternion<T>;
    const auto vector = [&](int k) { return Vec3(Eigen::Map<const Vec3>(x[k])); };
    const Vec3 x_m = point.At<T>(Quat(x[0]), vector(1), vector(2), Quat(x[3]), vector(4),
                                 Vec3((control.R_bs_nominal * control.end.u_s).template cast<T>()),
                                 x[5][0] - T(kTagS - kEndS));
    Vec3 distance = x_m - control.z_m.template cast<T>();
    for (Eigen::Index k = 0; k < control.directions.cols(); ++k) {
      distance -= control.directions.col(k).template cast<T>() * x[6][k];
    }
    if (control.with_datum_shift) distance += vector(7);
    const auto W = control.sqrt_information.template cast<T>();
    Eigen::Map<Eigen::Matrix<T, Eigen::Dynamic, 1>>(r, residual_size()) = W * distance;
    return true;
  }
};

class Control : public testing::CorrectedMotion {
 protected:
  /// A return 10 m from the surveyed point.
  PreparedControl Make(const ImuCorrection& correction, bool bridge) const {
    PreparedControl control;
    control.end.tag_s = kTagS;
    control.end.partial = Preintegrate(imu_, 1.0, kEndS, correction, kNoise);
    control.end.u_s = Vector3d(950.0, 10.0, 300.0);
    control.end.p_nominal_m = motion_.Pose(1.0).p_mb;
    if (bridge) {
      control.end.bridge = std::make_shared<IncrementConditioning>(
          motion_.frame, control.end.partial, Preintegrate(imu_, 1.0, 2.0, correction, kNoise));
    }
    control.R_bs_nominal << 0, 1, 0, 0, 0, 1, 1, 0, 0;
    const MapPose pose = motion_.Pose(kEndS);
    control.z_m =
        pose.p_mb + pose.q_mb * (control.R_bs_nominal * control.end.u_s) + Vector3d(6.0, 0.0, 8.0);
    return control;
  }

  std::vector<VectorXd> Values(const PreparedControl& control, bool effects,
                               std::mt19937& rng) const {
    const MapPose pose = motion_.Pose(1.0);
    const double angle = rng() % 2 == 0 ? 1e-3 : 0.3;
    const auto turned = [&](const Eigen::Quaterniond& q) {
      return State(q * Exp(testing::RandomVector<3>(rng, angle)));
    };
    std::vector<VectorXd> x{
        turned(pose.q_mb),
        pose.p_mb + testing::RandomVector<3>(rng, 0.5),
        pose.v_m + testing::RandomVector<3>(rng, 0.5),
        turned(Eigen::Quaterniond::Identity()),
        Vector3d(0.14, -0.02, 0.21),
        VectorXd(VectorXd::Constant(1, 1e-3)),
        VectorXd(testing::RandomVector<3>(rng, 0.1).head(control.directions.cols()))};
    if (control.with_datum_shift) x.push_back(testing::RandomVector<3>(rng, 0.1));
    if (control.end.bridge) x.push_back(turned(motion_.Attitude(2.0)));
    if (effects) {
      x.push_back(testing::RandomVector<3>(rng, 1e-2));
      x.push_back(VectorXd(VectorXd::Constant(2, 1e-3)));
    }
    return x;
  }
};

TEST_F(Control, TheResidualIsTheDistanceFromTheSurveyedPoint) {
  PreparedControl control = Make({}, false);
  control.end.partial = Preintegrate(imu_, 1.0, kEndS, {}, kNoise);
  control.end.tag_s = kEndS;
  const MapPose pose = motion_.Pose(1.0);
  const std::vector<VectorXd> x{State(pose.q_mb),
                                pose.p_mb,
                                pose.v_m,
                                State(Eigen::Quaterniond::Identity()),
                                Vector3d::Zero(),
                                VectorXd::Zero(1),
                                VectorXd(Vector3d(-6.0, 0.0, 0.0))};
  std::vector<const double*> values;
  for (const VectorXd& block : x) values.push_back(block.data());
  Vector3d r;
  ASSERT_TRUE(
      PointToControl(motion_.frame, control, {}, {}).Evaluate(values.data(), r.data(), nullptr));
  EXPECT_NEAR((r - Vector3d(0.0, 0.0, -8.0)).norm(), 0.0, 1e-3);  // discrete inertial data
  control.sqrt_information = Eigen::RowVector3d(0.0, 0.0, 1.0 / 0.02);
  double distance = 0.0;
  ASSERT_TRUE(
      PointToControl(motion_.frame, control, {}, {}).Evaluate(values.data(), &distance, nullptr));
  EXPECT_NEAR(distance, -400.0, 0.05);
}

struct Shape {
  bool plane, shift, bridge;
};

class ControlShapes : public Control, public ::testing::WithParamInterface<Shape> {};

TEST_P(ControlShapes, JacobiansAgreeAtRandomStates) {
  const Shape shape = GetParam();
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 rng(seed);
    PreparedControl control = Make(shape.bridge ? scaled_ : plain_, shape.bridge);
    control.with_datum_shift = shape.shift;
    const Vector3d normal = Vector3d(0.2, -0.1, 1.0).normalized();
    if (shape.plane) {
      control.directions = normal;
      control.sqrt_information = normal.transpose() / 0.02;
    } else {
      control.sqrt_information = Matrix3d(Vector3d(50.0, 60.0, 30.0).asDiagonal());
    }
    std::vector<GravitationBasis> attraction;
    if (shape.bridge) attraction.push_back(Eigen::Matrix<double, 3, 2>::Ones());
    const PointToControl factor(motion_.frame, control, {}, attraction);
    const std::vector<VectorXd> x = Values(control, shape.bridge, rng);
    if (shape.bridge) {
      testing::ExpectFactorConsistent(factor, x);
      continue;
    }
    const PlainControl plain{
        factor, LidarPoint(motion_.frame, control.end.partial, control.end.p_nominal_m), control};
    testing::ExpectFactorConsistent(factor, x, testing::DynamicAutodiff(plain));
  }
}

INSTANTIATE_TEST_SUITE_P(PointToControl, ControlShapes,
                         ::testing::Values(Shape{false, false, false}, Shape{false, true, false},
                                           Shape{true, false, false}, Shape{false, true, true},
                                           Shape{true, false, true}),
                         [](const auto& tested) {
                           const Shape& shape = tested.param;
                           return std::string(shape.plane ? "Plane" : "Point") +
                                  (shape.shift ? "Shifted" : "") + (shape.bridge ? "Bridged" : "");
                         });

TEST_F(Control, RejectsBadInputByName) {
  const auto make = [&](const PreparedControl& control) {
    return PointToControl(motion_.frame, control, {}, {});
  };
  PreparedControl control = Make(plain_, false);
  control.z_m.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(make(control), InvalidInput);
  control = Make(plain_, false);
  control.end.u_s.setZero();
  EXPECT_THROW(make(control), InvalidInput);
  control = Make(plain_, false);
  control.directions = Eigen::Matrix<double, 3, 2>::Ones();
  EXPECT_THROW(make(control), InvalidInput);
  control = Make(plain_, false);
  control.R_bs_nominal *= -1.0;
  EXPECT_THROW(make(control), InvalidInput);
}

}  // namespace dn::factors_test
