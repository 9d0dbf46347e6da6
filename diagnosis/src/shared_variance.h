#pragma once

#include <dn/solvers/residual_form.h>

#include <Eigen/Core>
#include <vector>

namespace dn::diagnosis_internal {

// Measurements share a part of their errors with their neighbours. In units of the stated noise,
// the error of a row is w + c. The variance of w is v. The variance of c is theta v, and c is the
// same for all rows of a cluster.

/// The sums of the residuals of one division of the rows into clusters.
struct ClusterSums {
  Eigen::VectorXd energy;  ///< square of the sum of each cluster
  Eigen::VectorXd count;   ///< rows of each cluster
  /// Variance of such a sum over the number of rows if the model holds: less than 1, because the
  /// unknowns absorb a part.
  double left = 1.0;
  /// Degrees of freedom of the sums under the model over those that they had if they were
  /// independent, at most 1. The log likelihood of the sums is multiplied by it.
  double independent = 1.0;

  /// `form` has a label for each cluster; `moments` are its own.
  ClusterSums(const ResidualForm& form, const FormMoments& moments,
              const Eigen::VectorXd& residual);
  ClusterSums() = default;
};

/// Posterior of the variances.
struct SharedVariance {
  /// Posterior mean of theta v times the indicator of each division, in stated variances.
  Eigen::VectorXd shared;
  double white = 1.0;        ///< posterior mean of v
  double probability = 0.0;  ///< posterior probability of theta > 0
  /// Posterior means and standard deviations if theta > 0: root of theta v in stated sigmas, and
  /// length of the clusters.
  double size = 0.0, size_sigma = 0.0, length_m = 0.0, length_sigma_m = 0.0;

  double total_shared() const { return shared.sum(); }  ///< 0 without divisions
};

/// Returns the posterior for several divisions with these lengths of their clusters. The prior
/// probability of theta = 0 is 1/2. Otherwise all divisions and theta = 1/128, 1/64, .. 1 are
/// equally probable. v has the likeliest value for each theta (restricted likelihood):
///
///   -2 ln L = n ln v + sum_c ln(1 + theta q_c),   q_c = left count_c,
///   n v = within + sum_c energy_c / (q_c (1 + theta q_c))
///
/// `sum_of_squares` and `redundancy` are those of all rows of the clusters.
SharedVariance EstimateSharedVariance(const std::vector<ClusterSums>& divisions,
                                      const std::vector<double>& lengths_m, double sum_of_squares,
                                      double redundancy);

/// Returns the same for the prior, with v = 1.
SharedVariance PriorSharedVariance(const std::vector<double>& lengths_m);

/// Returns the posterior mean of a noise variance in stated variances, from a variance ratio with
/// these degrees of freedom. The prior is an inverse gamma distribution with the mean 1 and the
/// standard deviation 0.35, as if from 18 redundant measurements. Noise of 1.4 times the stated
/// sigma is then at two standard deviations.
double PosteriorNoiseVariance(double variance_ratio, double dof);
/// Returns the standard deviation of that posterior.
double PosteriorNoiseSigma(double variance_ratio, double dof);
/// Returns the standard deviation of the prior.
double PriorNoiseSigma();

}  // namespace dn::diagnosis_internal
