#include "boresight_tests.h"

#include <dn/distributions.h>
#include <dn/symmetric_eigen.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>

namespace dn::fleet_internal {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::uint64_t kSeed = 20240917;
constexpr double kMostDraws = 10000, kFewestDraws = 1000;
// Multiplications for the draws of a long fleet.
constexpr double kMostWork = 4e9;
constexpr double kRounding = 1e-12;

/// Returns R with R R^T = A, for a positive semidefinite A.
MatrixXd Root(const MatrixXd& A) {
  const SymmetricEigen parts(A);
  const double least = kRounding * parts.values.maxCoeff();
  const VectorXd root =
      parts.values.unaryExpr([least](double v) { return v > least ? std::sqrt(v) : 0.0; });
  return parts.vectors * root.asDiagonal();
}

Index DrawCount(Index rows) {
  const auto n = static_cast<double>(rows);
  return static_cast<Index>(std::clamp(kMostWork / (n * n), kFewestDraws, kMostDraws));
}

}  // namespace

BoresightTests::BoresightTests(const FleetEstimate& estimate, Index flights)
    : flights_(flights),
      score_(estimate.Score().head(3 * flights)),
      A_(estimate.ScoreCovariance().topLeftCorner(3 * flights, 3 * flights)) {
  summed_ = MatrixXd::Zero(3 * flights, 3);
  for (Index k = flights - 1; k >= 0; --k) {
    Matrix3d sum = A_.block<3, 3>(3 * k, 3 * k);
    if (k + 1 < flights) {
      sum += summed_.middleRows<3>(3 * (k + 1));
      for (Index j = k + 1; j < flights; ++j) {
        const Matrix3d cross = A_.block<3, 3>(3 * k, 3 * j);
        sum += cross + cross.transpose();
      }
    }
    summed_.middleRows<3>(3 * k) = sum;
  }
}

ChangeTest BoresightTests::Test(bool single, Index flight) const {
  Vector3d s = Vector3d::Zero();
  for (Index k = flight; k < (single ? flight + 1 : flights_); ++k) s += score_.segment<3>(3 * k);
  const Matrix3d A = single ? Matrix3d(A_.block<3, 3>(3 * flight, 3 * flight))
                            : Matrix3d(summed_.middleRows<3>(3 * flight));
  ChangeTest test{single, flight, Vector3d::Zero(), Matrix3d::Zero(), 0.0};
  test.covariance_rad2 = Eigen::LLT<Matrix3d>(A).solve(Matrix3d::Identity());
  test.change_rad = test.covariance_rad2 * s;
  test.statistic = s.dot(test.change_rad);
  return test;
}

ChangeTest BoresightTests::TestFlight(Index flight) const { return Test(true, flight); }

ChangeTest BoresightTests::TestFrom(Index flight) const { return Test(false, flight); }

std::vector<ChangeTest> BoresightTests::Candidates() const {
  std::vector<ChangeTest> tests;
  for (Index k = 1; k < flights_; ++k) tests.push_back(TestFrom(k));
  // For the first and the last flight, this is the change from the second or from the last one on.
  for (Index k = 1; k + 1 < flights_; ++k) tests.push_back(TestFlight(k));
  return tests;
}

double BoresightTests::FamilyPValue(const std::vector<ChangeTest>& tests, double statistic) const {
  std::vector<Matrix3d> whitening;
  for (const ChangeTest& test : tests) {
    whitening.push_back(Eigen::LLT<Matrix3d>(test.covariance_rad2).matrixL().transpose());
  }
  const MatrixXd root = Root(A_);
  std::mt19937_64 generator(kSeed);
  std::normal_distribution<double> normal;
  const Index draws = DrawCount(A_.rows());
  Index larger = 0;
  VectorXd z(A_.cols());
  for (Index d = 0; d < draws; ++d) {
    for (double& one : z) one = normal(generator);
    const VectorXd s = root * z;
    MatrixXd from(3, flights_);
    Vector3d sum = Vector3d::Zero();
    for (Index k = flights_ - 1; k >= 0; --k) from.col(k) = sum += s.segment<3>(3 * k);
    double largest = 0.0;
    for (std::size_t t = 0; t < tests.size(); ++t) {
      const Vector3d own = tests[t].single_flight ? Vector3d(s.segment<3>(3 * tests[t].flight))
                                                  : Vector3d(from.col(tests[t].flight));
      largest = std::max(largest, (whitening[t] * own).squaredNorm());
    }
    larger += largest >= statistic ? 1 : 0;
  }
  const double share = static_cast<double>(larger + 1) / static_cast<double>(draws + 1);
  return std::min(share, static_cast<double>(tests.size()) * ChiSquareTail(statistic, 3.0));
}

BoresightStability BoresightTests::TestAll() const {
  const std::vector<ChangeTest> tests = Candidates();
  const ChangeTest& likeliest =
      *std::max_element(tests.begin(), tests.end(),
                        [](const auto& a, const auto& b) { return a.statistic < b.statistic; });
  BoresightStability stability;
  stability.change.single_flight = likeliest.single_flight;
  stability.change.flight = static_cast<std::size_t>(likeliest.flight);
  stability.change.change = {likeliest.change_rad, likeliest.covariance_rad2};
  stability.change.statistic = likeliest.statistic;
  stability.p_value = FamilyPValue(tests, likeliest.statistic);
  // The scores of all flights but the first span those of all differences.
  const Index n = 3 * (flights_ - 1);
  const Eigen::LLT<MatrixXd> llt(A_.bottomRightCorner(n, n));
  stability.chi2 = score_.tail(n).dot(llt.solve(score_.tail(n)));
  stability.dof = n;
  stability.chi2_p_value = ChiSquareTail(stability.chi2, static_cast<double>(n));
  return stability;
}

}  // namespace dn::fleet_internal
