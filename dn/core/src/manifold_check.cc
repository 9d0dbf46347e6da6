#include <dn/error.h>
#include <dn/manifold_check.h>
#include <dn/ridders.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace dn {
namespace {

/// Relative to the step, or to the largest entry of the Jacobian.
constexpr double kManifoldTolerance = 1e-6;
/// Rounding errors of a value, relative to its largest coordinate.
constexpr double kValueRounding = 1e-13;
constexpr double kLongStep = 0.1, kShortStep = 1e-3;

class ManifoldCheck {
 public:
  ManifoldCheck(const BlockKind& kind, const double* x, const std::string& block_name)
      : kind_(kind),
        x_(Eigen::Map<const Eigen::VectorXd>(x, kind.stored_size)),
        name_(block_name) {}

  void Run() const {
    ExpectZeroStepKeeps();
    for (int k = 0; k < kind_.tangent_size; ++k) ExpectColumn(k);
    if (!kind_.manifold->has_exact_minus()) return;
    for (int k = 0; k < kind_.tangent_size; ++k) ExpectInverse(Eigen::VectorXd::Unit(Tangent(), k));
    ExpectInverse(Eigen::VectorXd::LinSpaced(Tangent(), 1.0, -0.5));
  }

 private:
  Eigen::Index Tangent() const { return kind_.tangent_size; }
  double Rounding() const { return kValueRounding * x_.lpNorm<Eigen::Infinity>(); }

  Eigen::VectorXd Moved(const Eigen::VectorXd& d) const {
    Eigen::VectorXd y(kind_.stored_size);
    Plus(kind_, x_.data(), d.data(), y.data());
    return y;
  }

  void ExpectZeroStepKeeps() const {
    const Eigen::VectorXd y = Moved(Eigen::VectorXd::Zero(Tangent()));
    for (Eigen::Index i = 0; i < y.size(); ++i) {
      Expect(y[i], x_[i], 1e-9 * x_.lpNorm<Eigen::Infinity>(), "Plus(x, 0)", "x", i, -1);
    }
  }

  /// Compares column k of PlusJacobian with the numerical derivative of Plus.
  void ExpectColumn(int k) const {
    const NumericalDerivative numeric = RiddersDerivative(
        [&](double step) { return Moved(step * Eigen::VectorXd::Unit(Tangent(), k)); }, kShortStep);
    const Eigen::VectorXd column = PlusJacobian(kind_, x_.data()).col(k);
    const double size =
        std::max(column.lpNorm<Eigen::Infinity>(), numeric.value.lpNorm<Eigen::Infinity>());
    for (Eigen::Index i = 0; i < column.size(); ++i) {
      Expect(column[i], numeric.value[i],
             kManifoldTolerance * size + 10.0 * numeric.error[i] + Rounding() / kShortStep,
             "PlusJacobian", "the derivative of Plus", i, k);
    }
  }

  void ExpectInverse(const Eigen::VectorXd& direction) const {
    Eigen::VectorXd d = kLongStep * direction, back(Tangent());
    const auto go_and_return = [&] { Minus(kind_, Moved(d).data(), x_.data(), back.data()); };
    go_and_return();
    if (!back.allFinite()) {
      d = kShortStep * direction;
      go_and_return();
    }
    for (Eigen::Index k = 0; k < d.size(); ++k) {
      Expect(back[k], d[k], kManifoldTolerance * d.norm() + Rounding(), "Minus(Plus(x, d), x)", "d",
             k, -1);
    }
  }

  void Expect(double value, double expected, double tolerance, const char* what,
              const char* expected_what, Eigen::Index row, int column) const {
    if (std::abs(value - expected) <= tolerance) return;
    char text[192];
    const std::string entry =
        column < 0 ? "coordinate " + std::to_string(row)
                   : "row " + std::to_string(row) + ", column " + std::to_string(column);
    std::snprintf(text, sizeof(text), "%s is %.9g in %s, but %s is %.9g", what, value,
                  entry.c_str(), expected_what, expected);
    throw InvalidInput("network: the kind of block '" + name_ + "' contradicts itself: " + text +
                       "; see the requirements in dn/manifold.h");
  }

  const BlockKind& kind_;
  Eigen::VectorXd x_;
  const std::string& name_;
};

}  // namespace

void CheckManifold(const BlockKind& kind, const double* x, const std::string& block_name) {
  ManifoldCheck(kind, x, block_name).Run();
}

}  // namespace dn
