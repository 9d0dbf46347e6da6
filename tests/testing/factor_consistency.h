#pragma once

#include <ceres/autodiff_cost_function.h>
#include <ceres/dynamic_autodiff_cost_function.h>
#include <dn/block.h>
#include <dn/factor.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <functional>
#include <limits>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "testing/random.h"

namespace dn::testing {

/// Another way to compute the residual and its Jacobians, with the signature of
/// FactorBase::Evaluate.
using Evaluator = std::function<bool(double const* const* x, double* r, double** J)>;

/// Tolerance between analytic and automatic differentiation. Both are exact except for rounding,
/// which the chain of products amplifies.
inline constexpr double kAutodiffTolerance = 1e-10;

/// Tolerance between analytic and Ridders' extrapolated differences, from their truncation error.
inline constexpr double kNumericTolerance = 1e-5;

/// A block whose Jacobian vanishes has only rounding errors of cancelling terms. It is compared on
/// the scale of the factor's largest Jacobian times this value.
inline constexpr double kVanishingBlock = 1e-6;

/// First step of Ridders' method in tangent coordinates (rad, m, m/s, ...).
inline constexpr double kNumericStep = 1e-2;

namespace internal {

/// Functor around a factor for Ceres's automatic differentiation.
template <class F>
struct FixedCall {
  const F* factor;
  template <class... Args>
  bool operator()(Args... args) const {
    return factor->Residual(args...);
  }
};

}  // namespace internal

/// Returns automatic differentiation of `template <class T> bool Residual(const T* x0, ..., T* r)
/// const` of a class derived from Factor<F, R, Kinds...>. The factor must outlive the evaluator.
template <class F>
Evaluator Autodiff(const F& factor) {
  return [&factor]<class... Kinds>(std::tuple<Kinds...>*) -> Evaluator {
    return [&factor](double const* const* x, double* r, double** J) {
      using Call = internal::FixedCall<F>;
      return ceres::AutoDiffCostFunction<Call, F::kResiduals, Kinds::kSize...>(new Call{&factor})
          .Evaluate(x, r, J);
    };
  }(static_cast<typename F::BlockKinds*>(nullptr));
}

namespace internal {

/// The same functor for a list of blocks.
template <class F>
struct DynamicCall {
  const F* factor;
  template <class T>
  bool operator()(T const* const* x, T* r) const {
    return factor->Residual(x, r);
  }
};

}  // namespace internal

/// Returns automatic differentiation of `template <class T> bool Residual(T const* const* x, T* r)
/// const` of a class derived from DynamicFactor. The factor must outlive the evaluator.
template <class F>
Evaluator DynamicAutodiff(const F& factor) {
  return [&factor](double const* const* x, double* r, double** J) {
    using Call = internal::DynamicCall<F>;
    ceres::DynamicAutoDiffCostFunction<Call> cost(new Call{&factor});
    for (const BlockKind& kind : factor.block_kinds()) cost.AddParameterBlock(kind.stored_size);
    cost.SetNumResiduals(factor.residual_size());
    return cost.Evaluate(x, r, J);
  };
}

namespace internal {

using RowMajorMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

inline std::vector<const double*> Pointers(const std::vector<Eigen::VectorXd>& x) {
  std::vector<const double*> pointers;
  for (const Eigen::VectorXd& block : x) pointers.push_back(block.data());
  return pointers;
}

/// Residual and stored Jacobians of the requested blocks; the other Jacobians stay NaN.
struct Evaluation {
  bool ok = false;
  Eigen::VectorXd r;
  std::vector<RowMajorMatrix> J;
};

inline Evaluation Evaluate(const Evaluator& evaluator, const FactorBase& f,
                           const std::vector<Eigen::VectorXd>& x, const std::vector<bool>& wanted) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  Evaluation e;
  e.r = Eigen::VectorXd::Constant(f.residual_size(), kNan);
  std::vector<double*> J;
  for (std::size_t i = 0; i < x.size(); ++i) {
    e.J.push_back(RowMajorMatrix::Constant(f.residual_size(), x[i].size(), kNan));
  }
  for (std::size_t i = 0; i < x.size(); ++i) J.push_back(wanted[i] ? e.J[i].data() : nullptr);
  e.ok = evaluator(Pointers(x).data(), e.r.data(), J.data());
  return e;
}

inline Eigen::VectorXd ResidualAt(const FactorBase& f, std::vector<Eigen::VectorXd> x,
                                  std::size_t block, const Eigen::VectorXd& d) {
  Eigen::VectorXd moved(x[block].size());
  Plus(f.block_kinds()[block], x[block].data(), d.data(), moved.data());
  x[block] = moved;
  Eigen::VectorXd r(f.residual_size());
  EXPECT_TRUE(f.Evaluate(Pointers(x).data(), r.data(), nullptr));
  return r;
}

/// Returns d r / d (tangent coordinate `column` of `block`) by Ridders' method: central differences
/// with decreasing steps, extrapolated to step zero. The tableau entry with the smallest change is
/// used.
inline Eigen::VectorXd RiddersColumn(const FactorBase& f, const std::vector<Eigen::VectorXd>& x,
                                     std::size_t block, int column) {
  constexpr int kSteps = 10;
  constexpr double kShrink = 2.0;
  const int tangent_size = f.block_kinds()[block].tangent_size;
  std::vector<Eigen::VectorXd> previous;
  Eigen::VectorXd best;
  double best_error = std::numeric_limits<double>::infinity();
  double h = kNumericStep;
  for (int i = 0; i < kSteps; ++i, h /= kShrink) {
    const Eigen::VectorXd d = h * Eigen::VectorXd::Unit(tangent_size, column);
    std::vector<Eigen::VectorXd> row{(ResidualAt(f, x, block, d) - ResidualAt(f, x, block, -d)) /
                                     (2.0 * h)};
    double factor = kShrink * kShrink;
    for (std::size_t k = 0; k < previous.size(); ++k, factor *= kShrink * kShrink) {
      row.push_back((factor * row[k] - previous[k]) / (factor - 1.0));
      const double error = std::max((row[k + 1] - row[k]).lpNorm<Eigen::Infinity>(),
                                    (row[k + 1] - previous[k]).lpNorm<Eigen::Infinity>());
      if (error < best_error) {
        best_error = error;
        best = row[k + 1];
      }
    }
    previous = std::move(row);
  }
  return best;
}

inline double LargestEntry(const Eigen::MatrixXd& m) {
  return m.size() == 0 ? 0.0 : m.lpNorm<Eigen::Infinity>();
}

inline void ExpectBlockNear(const Eigen::MatrixXd& J, const Eigen::MatrixXd& reference,
                            double tolerance, const std::string& what) {
  EXPECT_LE(LargestEntry(J - reference), tolerance) << what << "\nEvaluate:\n"
                                                    << J << "\nreference:\n"
                                                    << reference;
  EXPECT_TRUE(J.allFinite()) << what;
}

/// Returns the Jacobians of the factor in the tangent coordinates of each block.
inline std::vector<Eigen::MatrixXd> InTangent(const FactorBase& f,
                                              const std::vector<Eigen::VectorXd>& x,
                                              const std::vector<RowMajorMatrix>& J_stored) {
  std::vector<Eigen::MatrixXd> J;
  for (std::size_t i = 0; i < x.size(); ++i) {
    J.push_back(J_stored[i] * PlusJacobian(f.block_kinds()[i], x[i].data()));
  }
  return J;
}

/// Returns the scale for comparing the Jacobian of block i.
inline double Scale(const std::vector<Eigen::MatrixXd>& J, std::size_t i) {
  double largest = 0.0;
  for (const Eigen::MatrixXd& block : J) largest = std::max(largest, LargestEntry(block));
  return std::max(LargestEntry(J[i]), kVanishingBlock * largest);
}

inline void ExpectNumeric(const FactorBase& f, const std::vector<Eigen::VectorXd>& x,
                          const Evaluation& all) {
  const std::vector<Eigen::MatrixXd> J = InTangent(f, x, all.J);
  // Rounding of the residual, divided by the step.
  const double rounding =
      100.0 * std::numeric_limits<double>::epsilon() * LargestEntry(all.r) / kNumericStep;
  for (std::size_t i = 0; i < x.size(); ++i) {
    Eigen::MatrixXd numeric(J[i].rows(), J[i].cols());
    for (int c = 0; c < numeric.cols(); ++c) numeric.col(c) = RiddersColumn(f, x, i, c);
    ExpectBlockNear(J[i], numeric, kNumericTolerance * Scale(J, i) + rounding,
                    "numeric derivative, block " + std::to_string(i));
  }
}

inline void ExpectAutodiff(const FactorBase& f, const std::vector<Eigen::VectorXd>& x,
                           const Evaluation& all, const Evaluator& autodiff) {
  const Evaluation reference = Evaluate(autodiff, f, x, std::vector<bool>(x.size(), true));
  ASSERT_TRUE(reference.ok);
  EXPECT_LE(LargestEntry(all.r - reference.r),
            kAutodiffTolerance * std::max(1.0, LargestEntry(all.r)))
      << "residual of Evaluate " << all.r.transpose() << ", of Residual<T> "
      << reference.r.transpose();
  const std::vector<Eigen::MatrixXd> J = InTangent(f, x, all.J);
  const std::vector<Eigen::MatrixXd> J_reference = InTangent(f, x, reference.J);
  for (std::size_t i = 0; i < x.size(); ++i) {
    ExpectBlockNear(J[i], J_reference[i], kAutodiffTolerance * Scale(J_reference, i),
                    "automatic differentiation, block " + std::to_string(i));
  }
}

/// Checks evaluation without Jacobians, with an array of null Jacobians, and with one Jacobian at a
/// time.
inline void ExpectNullJacobiansRespected(const FactorBase& f, const std::vector<Eigen::VectorXd>& x,
                                         const Evaluation& all) {
  Eigen::VectorXd r(f.residual_size());
  ASSERT_TRUE(f.Evaluate(Pointers(x).data(), r.data(), nullptr));
  EXPECT_EQ(r, all.r) << "residual differs without Jacobians";

  const Evaluator evaluator = [&f](auto... args) { return f.Evaluate(args...); };
  const Evaluation none = Evaluate(evaluator, f, x, std::vector<bool>(x.size(), false));
  ASSERT_TRUE(none.ok);
  EXPECT_EQ(none.r, all.r) << "residual differs with null Jacobians";
  for (std::size_t i = 0; i < x.size(); ++i) {
    std::vector<bool> wanted(x.size(), false);
    wanted[i] = true;
    const Evaluation one = Evaluate(evaluator, f, x, wanted);
    ASSERT_TRUE(one.ok);
    EXPECT_EQ(one.r, all.r) << "residual differs with only Jacobian " << i;
    EXPECT_EQ(one.J[i], all.J[i]) << "Jacobian " << i << " differs when asked for alone";
  }
}

}  // namespace internal

/// Returns the stored values of a vector or a quaternion (x, y, z, w) for ExpectFactorConsistent.
template <class Derived>
Eigen::VectorXd State(const Eigen::MatrixBase<Derived>& v) {
  return v;
}
inline Eigen::VectorXd State(const Eigen::Quaterniond& q) { return q.coeffs(); }

/// Checks a factor at the stored block values x:
///
/// - its Jacobians in the tangent equal Ridders' numeric differentiation through dn::Plus;
/// - residual and Jacobians equal those of `autodiff`, if given (Autodiff or DynamicAutodiff);
/// - the residual does not depend on the requested Jacobians, and null ones are not written.
inline void ExpectFactorConsistent(const FactorBase& f, const std::vector<Eigen::VectorXd>& x,
                                   const Evaluator& autodiff = nullptr) {
  ASSERT_EQ(x.size(), f.block_kinds().size());
  for (std::size_t i = 0; i < x.size(); ++i) {
    ASSERT_EQ(x[i].size(), f.block_kinds()[i].stored_size) << "block " << i;
  }
  const Evaluator evaluator = [&f](auto... args) { return f.Evaluate(args...); };
  const internal::Evaluation all =
      internal::Evaluate(evaluator, f, x, std::vector<bool>(x.size(), true));
  ASSERT_TRUE(all.ok);
  ASSERT_TRUE(all.r.allFinite()) << all.r.transpose();
  internal::ExpectNumeric(f, x, all);
  if (autodiff) internal::ExpectAutodiff(f, x, all, autodiff);
  internal::ExpectNullJacobiansRespected(f, x, all);
}

}  // namespace dn::testing
