#include <dn/noise.h>
#include <gtest/gtest.h>

#include <limits>

namespace dn::core_test {

constexpr double kNoiseTolerance = 1e-14;  ///< relative; rounding

TEST(Noise, SigmaWhitens) {
  const auto noise = Noise<3>::Sigma({0.02, 0.02, 0.05});
  const Eigen::Vector3d whitened = noise.sqrt_information() * Eigen::Vector3d(0.04, -0.02, 0.05);
  EXPECT_LE((whitened - Eigen::Vector3d(2.0, -1.0, 1.0)).norm(), kNoiseTolerance);
  EXPECT_NEAR(noise.covariance()(2, 2), 0.0025, kNoiseTolerance);
  EXPECT_EQ(Noise<2>::Sigma(0.5).sqrt_information()(1, 1), 2.0);
}

TEST(Noise, CovarianceIsGivenBack) {
  Eigen::Matrix3d C;
  C << 4e-4, 1e-4, -2e-5, 1e-4, 9e-4, 3e-5, -2e-5, 3e-5, 1e-2;
  const auto noise = Noise<3>::Covariance(C);
  const Eigen::Matrix3d& W = noise.sqrt_information();
  EXPECT_LE((W * C * W.transpose() - Eigen::Matrix3d::Identity()).norm(), 10 * kNoiseTolerance);
  EXPECT_LE((noise.covariance() - C).norm(), kNoiseTolerance * C.norm());
}

TEST(Noise, RejectsWhatIsNoStandardDeviation) {
  const double inf = std::numeric_limits<double>::infinity();
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double sigma : {0.0, -1.0, inf, nan, 1e-310}) {
    EXPECT_THROW(Noise<2>::Sigma(sigma), InvalidInput) << sigma;
  }
  try {
    Noise<3>::Sigma({1.0, -2.0, 1.0});
    FAIL() << "accepted";
  } catch (const InvalidInput& error) {
    EXPECT_NE(std::string(error.what()).find("standard deviation 1 of 3 is -2"), std::string::npos);
  }
}

// A fixed size that differs does not compile: see compile_errors/noise_size.cc.
TEST(Noise, RejectsDynamicMatricesOfAnotherSize) {
  const Eigen::VectorXd two = Eigen::VectorXd::Constant(2, 0.1);
  const Eigen::VectorXd three = Eigen::VectorXd::Constant(3, 0.1);
  const Eigen::MatrixXd wide = Eigen::MatrixXd::Identity(2, 3);
  EXPECT_THROW(Noise<3>::Sigma(two), InvalidInput);
  EXPECT_THROW(Noise<3>::Covariance(wide), InvalidInput);
  EXPECT_THROW(Noise<2>::Information(wide), InvalidInput);
  EXPECT_EQ(Noise<3>::Sigma(three).sqrt_information(), 10.0 * Eigen::Matrix3d::Identity());
  EXPECT_EQ(Noise<3>::Sigma(three.transpose()).sqrt_information(),
            10.0 * Eigen::Matrix3d::Identity());
  EXPECT_EQ(Noise<2>::Covariance(wide.leftCols(2)).sqrt_information(), Eigen::Matrix2d::Identity());
}

TEST(Noise, RejectsWhatIsNoCovariance) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Eigen::Matrix2d C;
  C << 1.0, 2.0, 2.0, 1.0;
  EXPECT_THROW(Noise<2>::Covariance(C), InvalidInput);  // indefinite
  C << 1.0, 1.0, 1.0, 1.0;
  EXPECT_THROW(Noise<2>::Covariance(C), InvalidInput);  // singular
  C << 1.0, 0.5, 0.0, 1.0;
  EXPECT_THROW(Noise<2>::Covariance(C), InvalidInput);  // not symmetric
  C << 1.0, nan, nan, 1.0;
  EXPECT_THROW(Noise<2>::Covariance(C), InvalidInput);
  EXPECT_THROW(Noise<2>::Covariance(-Eigen::Matrix2d::Identity()), InvalidInput);
}

}  // namespace dn::core_test
