#include <dn/network.h>
#include <gtest/gtest.h>

#include <cmath>

#include "testing/random.h"

namespace dn::core_test {

// Central differences with step 1e-6 of residuals of size 10.
constexpr double kFactorStep = 1e-6;
constexpr double kFactorDifferenceTolerance = 1e-7;
constexpr double kFactorTolerance = 1e-12;  ///< rounding, relative to Jacobians of size 10

/// r = q_l (q_r x + p): a user's own factor with every kind of block.
struct TwoRotations : AutoFactor<TwoRotations, 3, LeftRotation, Rotation, Vec<3>> {
  Eigen::Vector3d x{1.0, -2.0, 3.0};

  template <class T>
  bool Residual(const T* q_l_data, const T* q_r_data, const T* p_data, T* r_data) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q_l(q_l_data), q_r(q_r_data);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> p(p_data);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> r(r_data);
    r = q_l * (q_r * x.cast<T>() + p);
    return p[0] > T(-1e3);
  }
};

/// The same factor with analytic Jacobians.
class TwoRotationsAnalytic final
    : public Factor<TwoRotationsAnalytic, 3, LeftRotation, Rotation, Vec<3>> {
 public:
  bool Evaluate(double const* const* x, double* r, double** J) const override {
    const Eigen::Matrix3d R_l = Eigen::Map<const Eigen::Quaterniond>(x[0]).toRotationMatrix();
    const Eigen::Matrix3d R_r = Eigen::Map<const Eigen::Quaterniond>(x[1]).toRotationMatrix();
    const Eigen::Vector3d v = R_l * (R_r * point_ + Eigen::Map<const Eigen::Vector3d>(x[2]));
    for (int i = 0; i < 3; ++i) r[i] = v[i];
    Put<0>(x, J, -Skew(v));
    Put<1>(x, J, -R_l * R_r * Skew(point_));
    Put<2>(x, J, R_l);
    return true;
  }

 private:
  Eigen::Vector3d point_{1.0, -2.0, 3.0};
};

struct Fixture {
  Network net;
  Block<LeftRotation> q_l;
  Block<Rotation> q_r;
  Block<Vec<3>> p;

  explicit Fixture(unsigned seed) {
    std::mt19937 rng(seed);
    q_l = net.AddLeftRotation("l", testing::RandomRotation(rng));
    q_r = net.AddRotation("r", testing::RandomRotation(rng));
    p = net.AddVector<3>("p", testing::RandomVector(rng, 5.0));
  }
};

TEST(AutoFactor, TangentJacobiansAreDifferencesAlongPlus) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Fixture f(seed);
    const FactorId id = f.net.Add(TwoRotations{}, f.q_l, f.q_r, f.p);
    Eigen::VectorXd r, r_plus, r_minus;
    std::vector<Eigen::MatrixXd> J;
    ASSERT_TRUE(f.net.EvaluateFactor(id, &r, &J));
    for (BlockId b = 0; b < 3; ++b) {
      BlockRecord& block = f.net.block(b);
      const Eigen::VectorXd x =
          Eigen::Map<Eigen::VectorXd>(block.value.get(), block.kind.stored_size);
      for (int k = 0; k < 3; ++k) {
        const Eigen::Vector3d d = kFactorStep * Eigen::Vector3d::Unit(k), minus_d = -d;
        Plus(block.kind, x.data(), d.data(), block.value.get());
        ASSERT_TRUE(f.net.EvaluateFactor(id, &r_plus));
        Plus(block.kind, x.data(), minus_d.data(), block.value.get());
        ASSERT_TRUE(f.net.EvaluateFactor(id, &r_minus));
        std::copy_n(x.data(), x.size(), block.value.get());
        EXPECT_LE(((r_plus - r_minus) / (2.0 * kFactorStep) - J[static_cast<std::size_t>(b)].col(k))
                      .norm(),
                  kFactorDifferenceTolerance);
      }
    }
  }
}

TEST(Factor, PutLiftsTangentJacobians) {
  for (unsigned seed = 0; seed < 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Fixture f(seed);
    const FactorId automatic = f.net.Add(TwoRotations{}, f.q_l, f.q_r, f.p);
    const FactorId analytic = f.net.Add(TwoRotationsAnalytic{}, f.q_l, f.q_r, f.p);
    Eigen::VectorXd r_automatic, r_analytic;
    std::vector<Eigen::MatrixXd> J_automatic, J_analytic;
    ASSERT_TRUE(f.net.EvaluateFactor(automatic, &r_automatic, &J_automatic));
    ASSERT_TRUE(f.net.EvaluateFactor(analytic, &r_analytic, &J_analytic));
    EXPECT_LE((r_automatic - r_analytic).norm(), kFactorTolerance);
    for (std::size_t i = 0; i < 3; ++i) {
      EXPECT_LE((J_automatic[i] - J_analytic[i]).norm(), kFactorTolerance);
    }
  }
}

TEST(Factor, NullJacobiansAreSkipped) {
  const Eigen::Vector4d q(0.0, 0.0, 0.0, 1.0);
  const Eigen::Vector3d p(1.0, 1.0, 1.0);
  const double* x[] = {q.data(), q.data(), p.data()};
  Eigen::Matrix<double, 3, 3, Eigen::RowMajor> J_p;
  double* J[] = {nullptr, nullptr, J_p.data()};
  Eigen::Vector3d r;
  const TwoRotations automatic;
  const TwoRotationsAnalytic analytic;
  for (const FactorBase* factor :
       {static_cast<const FactorBase*>(&automatic), static_cast<const FactorBase*>(&analytic)}) {
    J_p.setZero();
    EXPECT_TRUE(factor->Evaluate(x, r.data(), J));
    EXPECT_EQ(J_p, (Eigen::Matrix<double, 3, 3, Eigen::RowMajor>::Identity()));
    EXPECT_TRUE(factor->Evaluate(x, r.data(), nullptr));
    EXPECT_EQ(r, Eigen::Vector3d(2.0, -1.0, 4.0));
  }
}

TEST(Factor, KnowsItsBlocks) {
  const TwoRotations factor;
  EXPECT_EQ(factor.residual_size(), 3);
  ASSERT_EQ(factor.block_kinds().size(), 3u);
  EXPECT_EQ(factor.block_kinds()[0], LeftRotation::kKind);
  EXPECT_EQ(factor.block_kinds()[1], Rotation::kKind);
  EXPECT_EQ(factor.block_kinds()[2], Vec<3>::kKind);
}

TEST(Factor, AnUndefinedModelIsPassedOn) {
  Fixture f(0);
  const FactorId id = f.net.Add(TwoRotations{}, f.q_l, f.q_r, f.p);
  f.net.SetValue(f.p, {-1e4, 0.0, 0.0});
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  EXPECT_FALSE(f.net.EvaluateFactor(id, &r));
  EXPECT_FALSE(f.net.EvaluateFactor(id, &r, &J));
}

TEST(InvalidInput, SaysWhere) {
  EXPECT_EQ((FileLocation{"imu.csv", 12, 3}.ToString()), "imu.csv:12:3");
  EXPECT_EQ((FileLocation{"imu.csv", 12, 0}.ToString()), "imu.csv:12");
  EXPECT_EQ((FileLocation{"imu.csv", 0, 3}.ToString()), "imu.csv");
  EXPECT_EQ(FileLocation{}.ToString(), "");
}

}  // namespace dn::core_test
