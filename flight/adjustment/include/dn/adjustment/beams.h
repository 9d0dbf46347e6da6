#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/builder/beam_unknowns.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

namespace dn {

/// Corrections of the beams of a scanner (BeamUnknown), one element per beam, in `unit`. They are
/// relative to the mean of the beams that measured pairs, and so are their sigmas.
struct BeamCorrections {
  BeamUnknown unknown;
  std::string scanner;  ///< name of the scanner; empty without a list
  std::string unit;     ///< deg or m
  double per_si = 1.0;  ///< `unit` = SI value * per_si
  std::vector<double> value, sigma, prior_sigma;

  /// Returns whether the pairs say more about beam k than its prior: its variance is at most half
  /// that of the prior.
  bool IsObservable(std::size_t k) const;
  /// Adds a change of the values, and variances of independent errors, SI.
  void AddChange(const Eigen::VectorXd& change, const Eigen::VectorXd& variance);

  /// Returns the numbers of the beams that are not observable.
  std::vector<std::size_t> NotObservable() const;
};

/// Returns the corrections of all scanners with several beams.
std::vector<BeamCorrections> ExtractBeams(const Adjustment& adjustment, const Marginals& marginals);

}  // namespace dn
