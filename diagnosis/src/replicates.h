#pragma once

#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "locations.h"
#include "screen.h"

namespace dn::diagnosis_internal {

/// Weight of the identity in the shrunk correlation matrix of the replicates.
inline constexpr double kShrunk = 0.1;

/// Statistics of one set of residuals, as the diagnosis uses them.
struct ResidualSummary {
  Eigen::VectorXd locations;     ///< Locations::Evaluate
  Eigen::VectorXd log_evidence;  ///< of each family of the screen
  double size_nats = 0.0;
  double pair_rms_m = 0.0;
  double gnss_rms_m = 0.0;
};

/// Computes the statistics of residuals of the network with their scores.
ResidualSummary SummariseResiduals(const Screen& screen, const Locations& locations,
                                   const Eigen::VectorXd& residual, const Eigen::VectorXd& scores);

/// Linear replicates: flights with the same epochs, geometry, correspondences and weights, with
/// errors as the model assumes. Their residuals are M e, e ~ N(0, I).
struct ReplicateSet {
  std::vector<ResidualSummary> all;
};

struct ReplicateOptions {
  int count = 400;
  std::uint64_t seed = 1;
  int threads = 1;
  std::function<void(double fraction)> progress = {};
  std::function<bool()> interrupted = {};
};

/// Makes linear replicates. Throws Interrupted.
ReplicateSet MakeReplicates(const Marginals& marginals, const Screen& screen,
                            const Locations& locations, const ReplicateOptions& options);

/// Comparison of a flight with its replicates. The first half of them standardises and the second
/// half ranks, so that p is exact under the model.
struct ReplicateTest {
  /// p-value of the smallest of the three ranks; by fitted distributions beyond all replicates
  double p_value = 1.0;
  double p_omnibus = 1.0;     ///< of z^T C^-1 z
  double p_largest = 1.0;     ///< of max |z|
  double p_library = 1.0;     ///< of the largest log evidence
  double omnibus = 0.0;       ///< z^T C^-1 z
  double omnibus_mean = 0.0;  ///< over the replicates
  std::vector<double> omnibus_of_replicates;
  Eigen::VectorXd z;            ///< of each location
  Eigen::VectorXd p_adjusted;   ///< of each location, for all of them (step-down maxT)
  Eigen::VectorXd mean, sigma;  ///< of the locations over the replicates
  double evidence_95 = 0.0;     ///< quantile of the largest log evidence

  /// Returns the locations sorted by |z|, largest first.
  std::vector<Eigen::Index> LargestFirst() const;
};

/// Compares a flight with its replicates.
ReplicateTest CompareWithReplicates(const ResidualSummary& flight, const ReplicateSet& replicates);

/// Returns the p-value of a test of replicates against replicates. One third standardises and one
/// third ranks. The p-values of the last third are compared with the uniform distribution of
/// flights without a gap (Kolmogorov and Smirnov). The ranking replicates are the same for all, so
/// their number counts as that of a second sample.
double TestReplicateConsistency(const ReplicateSet& replicates);

}  // namespace dn::diagnosis_internal
