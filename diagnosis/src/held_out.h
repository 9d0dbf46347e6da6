#pragma once

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "explained_flight.h"
#include "folds.h"

namespace dn::internal {

/// How much better the data of all folds are predicted, each from the data outside it.
struct HeldOutGains {
  double gain_nats = 0.0;  ///< with all causes, over none
  /// Of each cause beside the others; nothing where the network has not both sides.
  std::vector<std::optional<double>> of_causes;
  /// Of the best effect that is not among the causes, beside them.
  double further_nats = 0.0;
  int folds = 0;  ///< that both networks determine without their data
};

struct HeldOutOptions {
  int of_each_kind = 6;  ///< folds
  int threads = 1;
  std::function<bool()> interrupted = {};
};

/// Held-out log predictive density of a flight with its causes over that without any. Of a
/// linearised network, over the data y_B of a fold and all others y_-B,
///
///   log p(y_B | y_-B) = log p(y) - log p(y_-B),
///   log p(y) = -1/2 (r^T M r + ln |N|) + ln |W| + const,   M = I - J N^-1 J^T:
///
/// two factorisations, whatever the size of the fold. W, the root of the weights, counts where an
/// effect is noise of another size. A fixed effect is estimated anew outside each fold; windows,
/// starts and sizes of processes are those of the whole flight. An effect k that the network lacks
/// adds log BF_k of all data less log BF_k of the data outside the fold (EvidenceForm): its size is
/// averaged over, which is M replaced by M - M L (I / v + A)^-1 L^T M. Measurements that either
/// adjustment left out are in no fold. Throws Interrupted.
HeldOutGains MeasureHeldOut(const ExplainedFlight& without, const ExplainedFlight& with,
                            const HeldOutOptions& options);

/// log p(y_B | y_-B) of factors of a network at its values, nats; then, for each candidate, what it
/// adds. Nothing where the others leave an unknown free.
class FoldDensity {
 public:
  /// An effect that the network lacks.
  struct Further {
    EffectModel model;
    Eigen::VectorXd typical;
  };

  FoldDensity(const Network& net, std::vector<Further> further);

  /// `factors` must be active.
  std::optional<Eigen::VectorXd> Of(const std::vector<FoldFactor>& factors) const;

 private:
  std::optional<Eigen::VectorXd> LogLikelihood(const Network& net) const;

  const Network& net_;
  std::vector<Further> further_;
  std::optional<Eigen::VectorXd> of_all_;
};

}  // namespace dn::internal
