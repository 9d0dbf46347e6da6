#pragma once

#include <dn/adjustment/checks.h>
#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/residual_form.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "noise_beyond_model.h"

namespace dn::diagnosis_internal {

/// Sums of residuals that are tested, with their moments if the model holds.
struct TestedForms {
  /// Those of the channels, then common errors, then clusters of pairs. The clusters are not
  /// tested: noise is estimated from them.
  std::vector<ResidualForm> all;
  std::vector<FormMoments> moments;
  Eigen::MatrixXd energies;  ///< of samples of residuals: one row per form, one column per sample
  std::size_t channels = 0;  ///< number of forms of channels
  std::size_t tested = 0;    ///< number of forms of channels and common errors

  std::vector<ResidualForm> Tested() const;
  std::vector<FormMoments> TestedMoments() const;

  /// Estimates the noise of the residuals beyond the stated one. `groups` are the tests of the
  /// channels.
  NoiseBeyondModel EstimateNoise(const std::vector<GroupCheck>& groups,
                                 const Eigen::VectorXd& residual) const;
};

/// Makes the forms of a flight. They have no clusters unless `with_clusters`.
TestedForms MakeTestedForms(const FlightNetwork& network, const Marginals& marginals,
                            bool with_clusters);

}  // namespace dn::diagnosis_internal
