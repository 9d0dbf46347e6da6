#pragma once

#include <dn/adjustment/checks.h>
#include <dn/adjustment/result.h>
#include <dn/solvers/residual_form.h>

#include <Eigen/Core>
#include <map>
#include <string>
#include <vector>

#include "shared_variance.h"

namespace dn::diagnosis_internal {

/// Edge lengths of the tiles of PairClusters, m.
inline const std::vector<double> kClusterLengths_m = {15.0, 30.0, 60.0, 120.0};

/// Noise of a flight beyond its model: the variance of each channel, and errors that pairs share
/// with their neighbours on the ground. Without an argument, the noise is as stated.
class NoiseBeyondModel {
 public:
  NoiseBeyondModel() = default;
  /// `groups` are the checks of the channels and of their axes, with their `forms` and `moments` in
  /// the same order. `clusters` are the forms of PairClusters with their moments. `residual` is
  /// that of the model for which the noise is estimated.
  NoiseBeyondModel(const std::vector<GroupCheck>& groups, const std::vector<ResidualForm>& forms,
                   const std::vector<FormMoments>& moments, std::vector<ResidualForm> clusters,
                   const std::vector<FormMoments>& cluster_moments,
                   const Eigen::VectorXd& residual);

  /// Returns the covariance that this noise adds to three angles, and appends its parts that are
  /// not small. The rows of `gain` are the shift of the angles per unit error of each residual.
  /// `pair_sigma_m` is the stated noise of a pair, `angle_sigma_rad` the sigmas without this noise.
  Eigen::Matrix3d AddedCovariance(const Eigen::MatrixXd& gain, double pair_sigma_m,
                                  const Eigen::Vector3d& angle_sigma_rad,
                                  std::vector<EffectContribution>* contributions) const;

  /// Returns the covariance that this noise adds to any unknowns; `gain` as in AddedCovariance.
  Eigen::MatrixXd AddedCovariance(const Eigen::MatrixXd& gain) const;

  /// Returns the expected value of a form over its value if the noise is as stated, at least 1.
  double Growth(const ResidualForm& form, const FormMoments& moments) const;

  /// Returns the largest factor of the variance of sums of residuals of pairs that have the same
  /// sign within a cluster, at least 1.
  double PairGrowth() const;

 private:
  struct Channel {
    ResidualForm form;
    double variance = 1.0, sigma = 0.0;  // posterior, in stated variances
  };

  /// One source of noise: the covariance that it adds, and how it is reported.
  struct Part {
    Eigen::Matrix3d covariance;
    EffectContribution words;
  };

  Part ChannelPart(const std::string& name, const Channel& channel,
                   const Eigen::MatrixXd& gain) const;
  Part SharedPart(const Eigen::MatrixXd& gain, double pair_sigma_m) const;
  /// Returns the variance of the independent noise of a channel, at least 1.
  double WhiteVariance(const std::string& channel) const;

  std::map<std::string, Channel> channels_;
  std::vector<ResidualForm> clusters_;
  SharedVariance pairs_;
};

}  // namespace dn::diagnosis_internal
