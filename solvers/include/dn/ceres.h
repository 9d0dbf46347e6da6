#pragma once

#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <dn/network.h>

#include <atomic>
#include <exception>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <type_traits>
#include <unordered_map>
#include <utility>
#include <vector>

namespace dn {

/// Factors, block kinds and networks in programs that use Ceres, and the reverse. For covariances
/// of a ceres::Problem see Marginals.
///
///   problem.AddParameterBlock(q_mb, 4, dn::MakeCeresManifold<dn::Rotation>().release());
///   problem.AddResidualBlock(dn::MakeCostFunction(dn::GnssPosition(z_m, noise)).release(),
///                            nullptr, q_mb, p_mb, a_b);

/// Returns the manifold of a block kind. Its tangent is that of dn::Plus: full angles, while the
/// quaternion manifolds of Ceres use half of the angle. Quaternions are stored as x, y, z, w.
std::unique_ptr<ceres::Manifold> MakeCeresManifold(const BlockKind& kind);
template <class Kind>
std::unique_ptr<ceres::Manifold> MakeCeresManifold() {
  return MakeCeresManifold(MakeBlockKind<Kind>());
}

/// Returns a factor as a cost function. Its parameter blocks are the blocks of the factor, in their
/// order and with their stored sizes. The residual is whitened. Blocks that are not vectors need
/// the manifold of their kind, because a factor defines its Jacobian only in the tangent. Evaluate
/// returns false if the factor is undefined or throws.
std::unique_ptr<ceres::CostFunction> MakeCostFunction(std::shared_ptr<const FactorBase> factor);
template <class F>
requires std::is_base_of_v<FactorBase, F> std::unique_ptr<ceres::CostFunction> MakeCostFunction(
    F factor) {
  return MakeCostFunction(std::make_shared<const F>(std::move(factor)));
}

/// Returns the factor of a function (see Network::Add) as a cost function:
/// MakeCostFunction<Vec<3>, Scalar>(function, noise).
template <class... Kinds, class Function, int R>
std::unique_ptr<ceres::CostFunction> MakeCostFunction(Function function, const Noise<R>& noise) {
  using Check = core_internal::CheckFunction<Function, Kinds...>;
  core_internal::ExpectFit<Check::Fit(), Check::template Size<R>(), R>();
  if constexpr (Check::template kGood<R>) {
    return MakeCostFunction(
        std::make_shared<const FunctionFactor<Function, R, Kinds...>>(std::move(function), noise));
  }
  return nullptr;
}

namespace solvers_internal {

/// Stores the first exception of the factors of a problem, because exceptions cannot cross the
/// threads of Ceres.
class FactorException {
 public:
  bool present() const { return present_; }
  void Store(std::exception_ptr exception);
  /// Throws the stored exception, if there is one.
  void Rethrow() const;

 private:
  std::atomic<bool> present_ = false;
  std::mutex mutex_;
  std::exception_ptr exception_;
};

}  // namespace solvers_internal

/// The active factors of a network as a ceres::Problem. It works on the values stored in the
/// network, which must outlive it: solving the problem moves the network.
class NetworkProblem {
 public:
  explicit NetworkProblem(Network& network);
  ~NetworkProblem();
  NetworkProblem(const NetworkProblem&) = delete;
  NetworkProblem& operator=(const NetworkProblem&) = delete;

  ceres::Problem& problem() { return problem_; }

  /// Throws the exception that a factor threw during an evaluation. Ceres reports only a failure.
  void RethrowFactorException() const { exception_.Rethrow(); }

 private:
  void AddFactor(Network& network, FactorId id);
  void AddBlock(BlockRecord& block);
  ceres::Manifold* FindManifold(const BlockKind& kind);

  solvers_internal::FactorException exception_;
  std::vector<std::pair<BlockKind, std::unique_ptr<ceres::Manifold>>> manifolds_;
  ceres::Problem problem_;
};

/// A ceres::Problem as a network. The residual blocks are factors, with their loss functions. The
/// parameter blocks are blocks with the tangent of their manifolds. The network has its own
/// copies of the present values. It calls the cost functions, loss functions and manifolds of the
/// problem, which must outlive it. Bounds and evaluation callbacks are not part of a network. The
/// weight of a loss function is rho', as for all losses whose second derivative is not positive.
class ProblemNetwork {
 public:
  /// `names` gives names to parameter blocks; the others are "block/<k>" in the order of the
  /// problem. Throws InvalidInput if a name is given twice, or if a manifold contradicts itself.
  explicit ProblemNetwork(const ceres::Problem& problem,
                          const std::map<const double*, std::string>& names = {});

  Network& network() { return network_; }
  const Network& network() const { return network_; }

  /// Returns the block of a parameter block. Throws InvalidInput if the problem does not have it.
  BlockId Find(const double* parameter_block) const;

  /// Copies the values of the network to the parameter blocks of the problem.
  void StoreValues() const;

 private:
  Network network_;
  std::vector<double*> parameter_blocks_;  // by BlockId
  std::unordered_map<const double*, BlockId> ids_;
};

}  // namespace dn
