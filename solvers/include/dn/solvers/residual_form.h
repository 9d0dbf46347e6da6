#pragma once

#include <dn/solvers/linearized_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace dn {

/// A quadratic form of the residuals of a linearised network: residuals with the same label are
/// summed, the sums squared and added. With a label for each residual it is their sum of squares.
struct ResidualForm {
  std::string name;
  std::string channel;     ///< whose residuals
  std::vector<int> label;  ///< per row; -1: takes no part
  int labels = 0;
  std::vector<std::string> label_name;  ///< one per label, or none

  double Energy(const Eigen::Ref<const Eigen::VectorXd>& residual) const;
  /// Sums of the rows of X by label: labels x columns.
  Eigen::MatrixXd SumByLabel(const Eigen::MatrixXd& X) const;
};

/// The sum of squares of each channel ("inertial gyro") and of each of its axes ("inertial gyro
/// x"), for the factors of the network that have a tag and are no priors.
std::vector<ResidualForm> ChannelForms(const LinearizedNetwork& linearized);

/// Mean and variance that a form has when the model of the network holds.
struct FormMoments {
  double mean = 0.0;
  double variance = 0.0;
  int samples = 0;  ///< from which they are known; 0: exact

  /// Of the chi-square variable with the same ratio of the two; as few as the samples leave
  /// possible, and at least one.
  double Dof() const;
  /// Probability that the form is as large, or as small; 1 where it can have one value only.
  double UpperTail(double energy) const;
  double LowerTail(double energy) const;
};

/// Calls `use` for each of 32 samples M e of what a fit leaves of errors e ~ N(0, I), of one fixed
/// seed, M as in Marginals::Project.
void ForSampledResiduals(const Marginals& marginals,
                         const std::function<void(const Eigen::Ref<const Eigen::VectorXd>&)>& use);

/// Mean and variance of the values that a form has for each of those.
FormMoments MomentsOfSample(const std::vector<double>& energies);

/// Of r = M e, e ~ N(0, I), M as in Marginals::Project, a form r^T S^T S r has the mean tr(S M S^T)
/// and the variance 2 tr((S M S^T)^2): these for networks of at most 400 rows; the moments of 32
/// samples of one fixed seed for larger ones. One pair of triangular solves per row or sample.
std::vector<FormMoments> MomentsOf(const Marginals& marginals,
                                   const std::vector<ResidualForm>& forms);

}  // namespace dn
