#pragma once

#include <dn/solvers/linearized_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace dn {

/// A quadratic form of the residuals of a linearised network. Residuals with the same label are
/// summed, and the squares of these sums are added. If every residual has its own label, the form
/// is the sum of squares.
struct ResidualForm {
  std::string name;
  std::string channel;     ///< channel of the residuals
  std::vector<int> label;  ///< label of each row; -1 if the row is not used
  int labels = 0;
  std::vector<std::string> label_name;  ///< one per label, or empty

  double Energy(const Eigen::Ref<const Eigen::VectorXd>& residual) const;
  /// Returns the sums of the rows of X by label: labels x columns.
  Eigen::MatrixXd SumByLabel(const Eigen::MatrixXd& X) const;
};

/// Returns the sum of squares of each channel ("inertial gyro") and of each of its axes ("inertial
/// gyro x"). Only tagged factors that are not priors are used.
std::vector<ResidualForm> ChannelForms(const LinearizedNetwork& linearized);

/// Mean and variance of a form if the model of the network holds.
struct FormMoments {
  double mean = 0.0;
  double variance = 0.0;
  int samples = 0;  ///< number of samples behind the values; 0 if they are exact

  /// Returns the degrees of freedom of the scaled chi-square variable with this mean and variance.
  /// With few samples the lower end of the plausible range is returned, and at least 1.
  double Dof() const;
  /// Returns the probability that the form is at least (UpperTail) or at most (LowerTail) `energy`;
  /// 1 if the variance is zero.
  double UpperTail(double energy) const;
  double LowerTail(double energy) const;
};

/// Calls `use` for each of 32 to 512 samples M e of the residuals after the fit. e ~ N(0, I) has a
/// fixed seed, and M is that of Marginals::Project. Small networks have more samples.
void ForEachSampledResidual(
    const Marginals& marginals,
    const std::function<void(const Eigen::Ref<const Eigen::VectorXd>&)>& use);

/// Returns the mean and variance of a form from its values for the samples of
/// ForEachSampledResidual.
FormMoments SampleMoments(const std::vector<double>& energies);

/// Returns the values of the forms for the samples of ForEachSampledResidual: forms x samples.
Eigen::MatrixXd SampleFormEnergies(const Marginals& marginals,
                                   const std::vector<ResidualForm>& forms);

/// Returns the mean and variance of each form r^T S^T S r for r = M e, e ~ N(0, I), M as in
/// Marginals::Project. Networks of at most 400 rows use the exact mean tr(S M S^T) and variance 2
/// tr((S M S^T)^2). Larger networks use samples with a fixed seed. The cost is one pair of
/// triangular solves per row or sample.
std::vector<FormMoments> ComputeFormMoments(const Marginals& marginals,
                                            const std::vector<ResidualForm>& forms);
/// Returns the same moments if the samples of a large network are known: `energies` are those of
/// SampleFormEnergies.
std::vector<FormMoments> ComputeFormMoments(const Marginals& marginals,
                                            const std::vector<ResidualForm>& forms,
                                            const Eigen::MatrixXd& energies);

}  // namespace dn
