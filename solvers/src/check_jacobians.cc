#include <dn/error.h>
#include <dn/parallel.h>
#include <dn/ridders.h>
#include <dn/solvers/check_jacobians.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <optional>
#include <typeindex>

namespace dn {
namespace {

// Tangent coordinates have different units, so that no single step suits them all.
constexpr double kFirstSteps[] = {1e-2, 1e-4, 1e-6};
/// A further step changes the residual by this share of its size, if the Jacobian is right. It
/// suits coordinates with very small units, and functions near a pole.
constexpr double kResidualShare = 1e-3;
/// A block whose Jacobian vanishes has only rounding errors. It is compared on the scale of the
/// largest Jacobian of the factor times this value.
constexpr double kVanishing = 1e-6;
/// Step of the one-sided derivatives at a kink.
constexpr double kKinkStep = 1e-6;
/// Multiple of the estimated error of a numerical derivative that counts as uncertain.
constexpr double kUncertain = 10.0;

bool IsBetween(double value, double one, double other) {
  return value >= std::min(one, other) && value <= std::max(one, other);
}

class FactorCheck {
 public:
  FactorCheck(const Network& network, FactorId id, double tolerance)
      : network_(network), id_(id), tolerance_(tolerance) {}

  std::vector<JacobianFault> Run() {
    std::vector<JacobianFault> faults;
    if (!network_.EvaluateFactor(id_, &r_, &J_) || !r_.allFinite()) return faults;
    for (const Eigen::MatrixXd& J : J_) {
      if (!J.allFinite()) return faults;
      largest_ = std::max(largest_, J.lpNorm<Eigen::Infinity>());
    }
    for (std::size_t i = 0; i < J_.size(); ++i) {
      if (network_.block(Block(i)).held) continue;
      if (const auto fault = CheckBlock(i)) faults.push_back(*fault);
    }
    return faults;
  }

 private:
  BlockId Block(std::size_t i) const { return network_.factor(id_).blocks[i]; }

  /// Returns the worst entry of a block if it is wrong.
  std::optional<JacobianFault> CheckBlock(std::size_t i) const {
    std::optional<JacobianFault> worst;
    double worst_excess = 0.0;
    const double scale = std::max(J_[i].lpNorm<Eigen::Infinity>(), kVanishing * largest_);
    for (Eigen::Index column = 0; column < J_[i].cols(); ++column) {
      std::vector<NumericalDerivative> numerical;
      for (const double step : kFirstSteps) numerical.push_back(Differentiate(i, column, step));
      const double slope = J_[i].col(column).lpNorm<Eigen::Infinity>();
      if (slope > 0.0) {
        const double size = std::max(1.0, r_.lpNorm<Eigen::Infinity>());
        numerical.push_back(Differentiate(i, column, kResidualShare * size / slope));
      }
      const Eigen::VectorXd forward = (ResidualAt(i, column, kKinkStep) - r_) / kKinkStep;
      const Eigen::VectorXd backward = (r_ - ResidualAt(i, column, -kKinkStep)) / kKinkStep;
      for (Eigen::Index row = 0; row < J_[i].rows(); ++row) {
        const double computed = J_[i](row, column);
        if (IsBetween(computed, forward[row], backward[row])) continue;
        const NumericalDerivative* nearest = nullptr;
        double excess = std::numeric_limits<double>::infinity();
        for (const NumericalDerivative& derivative : numerical) {
          const double beyond = Excess(computed, scale, derivative, row);
          if (!(beyond < excess)) continue;
          excess = beyond;
          nearest = &derivative;
        }
        if (nearest == nullptr || excess <= worst_excess) continue;
        worst_excess = excess;
        worst = MakeFault(i, row, column, nearest->value[row]);
      }
    }
    return worst;
  }

  /// Returns by how much the difference exceeds what tolerance, rounding and the error of the
  /// numerical derivative allow; at most 0 for a right entry.
  double Excess(double computed, double scale, const NumericalDerivative& numerical,
                Eigen::Index row) const {
    const double allowed = tolerance_ * scale + kUncertain * numerical.error[row];
    const double difference = std::abs(computed - numerical.value[row]);
    return std::isfinite(difference) && std::isfinite(allowed) ? difference - allowed : 0.0;
  }

  NumericalDerivative Differentiate(std::size_t i, Eigen::Index column, double step) const {
    NumericalDerivative derivative =
        RiddersDerivative([&](double h) { return ResidualAt(i, column, h); }, step);
    const double rounding =
        std::numeric_limits<double>::epsilon() * r_.lpNorm<Eigen::Infinity>() / step;
    derivative.error.array() += rounding;
    return derivative;
  }

  /// Returns the residual with one tangent coordinate of one block moved; NaN where it is
  /// undefined.
  Eigen::VectorXd ResidualAt(std::size_t i, Eigen::Index column, double step) const {
    std::vector<const double*> x;
    for (const BlockId b : network_.factor(id_).blocks) x.push_back(network_.block(b).value.get());
    const BlockKind& kind = network_.block(Block(i)).kind;
    const Eigen::VectorXd d = step * Eigen::VectorXd::Unit(kind.tangent_size, column);
    Eigen::VectorXd moved(kind.stored_size);
    Plus(kind, x[i], d.data(), moved.data());
    x[i] = moved.data();
    Eigen::VectorXd r(r_.size());
    bool defined = false;
    try {
      defined = network_.EvaluateStored(id_, x.data(), r.data(), nullptr);
    } catch (const Error&) {
      defined = false;
    }
    if (!defined) r.setConstant(std::numeric_limits<double>::quiet_NaN());
    return r;
  }

  JacobianFault MakeFault(std::size_t i, Eigen::Index row, Eigen::Index column,
                          double numerical) const {
    JacobianFault fault;
    fault.factor = id_;
    fault.block = Block(i);
    fault.row = static_cast<int>(row);
    fault.column = static_cast<int>(column);
    fault.computed = J_[i](row, column);
    fault.numerical = numerical;
    char numbers[128];
    std::snprintf(numbers, sizeof(numbers), "row %d, column %d is %.9g, but numerically %.9g",
                  fault.row, fault.column, fault.computed, fault.numerical);
    fault.text = network_.DescribeFactor(id_) + ": its Jacobian of block '" +
                 network_.block(fault.block).name + "' in " + numbers +
                 "; correct Evaluate of the factor or PlusJacobian of the block";
    return fault;
  }

  const Network& network_;
  FactorId id_;
  double tolerance_;
  Eigen::VectorXd r_;
  std::vector<Eigen::MatrixXd> J_;
  double largest_ = 0.0;
};

std::vector<FactorId> FactorsToCheck(const Network& network, int most_per_class) {
  std::map<std::type_index, std::vector<FactorId>> classes;
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    if (!network.factor(id).active) continue;
    const FactorBase& factor = *network.factor(id).factor;
    classes[typeid(factor)].push_back(id);
  }
  std::vector<FactorId> ids;
  for (const auto& [type, all] : classes) {
    const std::size_t wanted = most_per_class == 0
                                   ? all.size()
                                   : std::min(all.size(), static_cast<std::size_t>(most_per_class));
    for (std::size_t k = 0; k < wanted; ++k) {
      ids.push_back(all[wanted == 1 ? 0 : k * (all.size() - 1) / (wanted - 1)]);
    }
  }
  std::sort(ids.begin(), ids.end());
  return ids;
}

}  // namespace

void JacobianCheckOptions::Validate() const {
  if (!(tolerance > 0.0 && tolerance < 1.0)) {
    throw InvalidConfig("check of Jacobians: option tolerance is " + std::to_string(tolerance) +
                        ", must be in (0, 1)");
  }
  if (most_per_class < 0) {
    throw InvalidConfig("check of Jacobians: option most_per_class is " +
                        std::to_string(most_per_class) + ", must be at least 0");
  }
  if (threads < 1) {
    throw InvalidConfig("check of Jacobians: option threads is " + std::to_string(threads) +
                        ", must be at least 1");
  }
}

std::vector<JacobianFault> CheckJacobians(const Network& network,
                                          const JacobianCheckOptions& options) {
  options.Validate();
  const std::vector<FactorId> ids = FactorsToCheck(network, options.most_per_class);
  std::vector<std::vector<JacobianFault>> found(ids.size());
  ParallelFor(static_cast<int>(ids.size()), options.threads, [&](int k) {
    const auto at = static_cast<std::size_t>(k);
    found[at] = FactorCheck(network, ids[at], options.tolerance).Run();
  });
  std::vector<JacobianFault> faults;
  for (const auto& some : found) faults.insert(faults.end(), some.begin(), some.end());
  return faults;
}

}  // namespace dn
