#pragma once

#include <Eigen/Core>
#include <vector>

namespace dn::diagnosis_internal {

/// A shape that a process may have: the standard deviations of its coefficients if its size is 1.
struct ProcessShape {
  double tau_s = 0.0;
  Eigen::VectorXd sigma;
  double log_probability = 0.0;
};

/// A size that a process may have.
struct ProcessSize {
  double size = 0.0;
  double log_probability = 0.0;
};

/// Mean and variance of a number.
struct ProcessMoments {
  double mean = 0.0, variance = 0.0;
  double sigma() const;
};

/// Distribution of the coefficients e of a process over all its sizes g and shapes D_g. With the
/// scores s and the information A of its coefficients,
///
///   log p_g = log prior_g + 1/2 s^T P_g s - 1/2 log |I + D_g A|,   P_g = (A + D_g^-1)^-1,
///   mean = -sum p_g P_g s,   covariance = sum p_g P_g + covariance of the means.
///
/// Leaves out sizes and shapes a thousand times less probable than the most probable ones.
struct ProcessMixture {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
  /// Standard deviations of the coefficients by the posterior mean of D_g.
  Eigen::VectorXd prior_sigma;
  ProcessMoments size, log_size, tau_s;
  ProcessMoments size_before, log_size_before, tau_before_s;  ///< by the priors alone
};

/// Source of the probabilities of sizes and shapes.
enum class SizeSource {
  kDataAndPrior,
  kPrior,  ///< for designs without measured values
};

ProcessMixture MixProcess(const Eigen::VectorXd& s, const Eigen::MatrixXd& A,
                          const std::vector<ProcessSize>& sizes,
                          const std::vector<ProcessShape>& shapes,
                          SizeSource source = SizeSource::kDataAndPrior);

}  // namespace dn::diagnosis_internal
