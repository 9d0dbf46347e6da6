#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "folds.h"
#include "network_fit.h"

namespace dn::diagnosis_internal {

/// Gains in the prediction of all folds, each predicted from the data outside it.
struct HeldOutGains {
  double gain_nats = 0.0;  ///< with all causes, against none
  /// Gain of each cause given the others; nullopt if the network cannot be made without it.
  std::vector<std::optional<double>> cause_gains;
  /// Gain of the best effect that is not among the causes, given these causes.
  double further_nats = 0.0;
  int folds = 0;  ///< number of folds that both networks can predict
};

struct HeldOutOptions {
  int num_per_kind = 6;  ///< number of folds
  int threads = 1;
  std::function<bool()> interrupted = {};
};

/// Computes the gain in held-out log predictive density of a flight with its causes over that
/// without any. For a linearised network, with the data y_B of a fold and all other data y_-B,
///
///   log p(y_B | y_-B) = log p(y) - log p(y_-B),
///   log p(y) = -1/2 (r^T M r + ln |N|) + ln |W| + const,   M = I - J N^-1 J^T.
///
/// This needs two factorisations, whatever the size of the fold. W is the root of the weights; it
/// matters if an effect scales the noise. A fixed effect is estimated again outside each fold.
/// Windows, starts and sizes of processes are those of the whole flight.
///
/// An effect k that the network lacks adds log BF_k of all data minus log BF_k of the data outside
/// the fold (SizeAveragedEvidence). This averages over its size: M becomes M - M L (I / v + A)^-1
/// L^T M. Measurements that either adjustment left out are in no fold. Throws Interrupted.
HeldOutGains MeasureHeldOut(const NetworkFit& without, const NetworkFit& with,
                            const HeldOutOptions& options);

/// Log predictive density log p(y_B | y_-B) of factors of a network at its values, nats, and its
/// increase by further effects.
class FoldDensity {
 public:
  /// An effect that the network lacks.
  struct Further {
    EffectModel model;
    Eigen::VectorXd typical;
  };

  FoldDensity(const Network& net, std::vector<Further> further);

  /// Returns the log density, and its increase by each further effect. Returns nullopt if the other
  /// data leave an unknown undetermined. `factors` must be active.
  std::optional<Eigen::VectorXd> LogDensity(const std::vector<FoldFactor>& factors) const;

 private:
  std::optional<Eigen::VectorXd> LogLikelihood(const Network& net) const;

  const Network& net_;
  std::vector<Further> further_;
  std::optional<Eigen::VectorXd> of_all_;
};

}  // namespace dn::diagnosis_internal
