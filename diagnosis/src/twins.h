#pragma once

#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "locations.h"
#include "screen.h"

namespace dn::internal {

/// Share of the twins' correlation matrix that gives way to the identity.
inline constexpr double kShrunk = 0.1;

/// What one set of residuals looks like to the diagnosis.
struct Appearance {
  Eigen::VectorXd locations;     ///< Locations::Evaluate
  Eigen::VectorXd log_evidence;  ///< of each family of the screen
  double size_nats = 0.0;
  double pair_rms_m = 0.0;
  double gnss_rms_m = 0.0;
};

Appearance Look(const Screen& screen, const Locations& locations, const Eigen::VectorXd& residual,
                const Eigen::VectorXd& scores);

/// Linear twins: flights with the same epochs, geometry, correspondences and weights, whose errors
/// are those that the model assumes: residuals M e, e ~ N(0, I).
struct Twins {
  std::vector<Appearance> all;
};

struct TwinOptions {
  int count = 400;
  std::uint64_t seed = 1;
  int threads = 1;
  std::function<void(double fraction)> progress = {};
  std::function<bool()> interrupted = {};
};

/// Throws Interrupted.
Twins MakeTwins(const Marginals& marginals, const Screen& screen, const Locations& locations,
                const TwinOptions& options);

/// A flight against its twins. The first half of them standardises, the second half ranks, so that
/// p is exact under the model.
struct TwinTest {
  double p_value = 1.0;       ///< of the smallest of the three ranks
  double p_omnibus = 1.0;     ///< of z^T C^-1 z
  double p_largest = 1.0;     ///< of max |z|
  double p_library = 1.0;     ///< of the largest log evidence
  double omnibus = 0.0;       ///< z^T C^-1 z
  double omnibus_mean = 0.0;  ///< of the twins
  std::vector<double> omnibus_of_twins;
  Eigen::VectorXd z;            ///< of each location
  Eigen::VectorXd p_adjusted;   ///< of each location, for all of them (step-down maxT)
  Eigen::VectorXd mean, sigma;  ///< of the locations over the twins
  double evidence_95 = 0.0;     ///< quantile of the largest log evidence

  /// Locations by |z|.
  std::vector<Eigen::Index> LargestFirst() const;
};

TwinTest CompareWithTwins(const Appearance& flight, const Twins& twins);

/// Twins against twins: a third standardises, a third ranks, and the p-values of the last third are
/// compared with those of flights without a gap, which are uniform (Kolmogorov and Smirnov). The
/// ranks of all come from the same twins: their number counts as that of a second sample.
double TwinsAgainstTwins(const Twins& twins);

}  // namespace dn::internal
