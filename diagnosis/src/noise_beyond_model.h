#pragma once

#include <dn/adjustment/checks.h>
#include <dn/adjustment/result.h>
#include <dn/solvers/residual_form.h>

#include <Eigen/Core>
#include <random>
#include <string>
#include <vector>

#include "shared_variance.h"

namespace dn::diagnosis_internal {

/// Edge lengths of the tiles of PairClusters, m.
inline const std::vector<double> kClusterLengths_m = {15.0, 30.0, 60.0, 120.0};

/// Noise of a flight beyond its model: the variance of each channel, and errors that pairs share
/// with their neighbours on the ground. The axes of pairs differ, because matching knows heights
/// much better than the other coordinates, and have variances of their own. Without an argument,
/// the noise is as stated.
class NoiseBeyondModel {
 public:
  NoiseBeyondModel() = default;
  /// `groups` are the checks of the channels and of their axes, with their `forms` and `moments` in
  /// the same order. `clusters` are the forms of PairClusters with their moments. `residual` is
  /// that of the model for which the noise is estimated.
  NoiseBeyondModel(const std::vector<GroupCheck>& groups, const std::vector<ResidualForm>& forms,
                   const std::vector<FormMoments>& moments,
                   const std::vector<ResidualForm>& clusters,
                   const std::vector<FormMoments>& cluster_moments,
                   const Eigen::VectorXd& residual);

  /// Returns the covariance that this noise adds to three angles, and appends its parts that are
  /// not small. A part of the pairs has the size of its largest axis. The rows of `gain` are the
  /// shift of the angles per unit error of each residual. `pair_sigma_m` is the stated noise of a
  /// pair, `angle_sigma_rad` the sigmas without this noise.
  Eigen::Matrix3d AddedCovariance(const Eigen::MatrixXd& gain, double pair_sigma_m,
                                  const Eigen::Vector3d& angle_sigma_rad,
                                  std::vector<EffectContribution>* contributions) const;

  /// Returns the covariance that this noise adds to any unknowns; `gain` as in AddedCovariance.
  Eigen::MatrixXd AddedCovariance(const Eigen::MatrixXd& gain) const;

  /// Returns the channels whose noise exceeds the stated one by more than a thousandth of its
  /// variance.
  std::vector<std::string> Channels() const;

  /// Returns samples of the errors of a channel beyond those of the stated noise, in sigmas of each
  /// residual. A row is a residual, a column is a sample.
  Eigen::MatrixXd Sample(const std::string& channel, int samples, std::mt19937_64* generator) const;

  /// Returns the expected value of a form over its value if the noise is as stated, at least 1.
  double Growth(const ResidualForm& form, const FormMoments& moments) const;

  /// Returns the largest factor of the variance of sums of residuals of pairs that have the same
  /// sign within a cluster, at least 1.
  double PairGrowth() const;

 private:
  /// Residuals whose noise has one size: those of a channel, or of one axis of the pairs.
  struct Source {
    ResidualForm form;
    double variance = 1.0, sigma = 0.0;  // posterior, in stated variances
    std::vector<ResidualForm> clusters;  // one per length; none for other channels than the pairs
    SharedVariance shared;               // of the clusters

    /// Returns the variance of the independent noise, at least 1.
    double WhiteVariance() const;
    /// Returns the covariance of sums with these weights of the residuals that is beyond that of
    /// the stated noise: one row of `gain` per residual.
    Eigen::MatrixXd WhiteCovariance(const Eigen::MatrixXd& gain) const;
    Eigen::MatrixXd SharedCovariance(const Eigen::MatrixXd& gain) const;
  };

  /// One entry of the list of contributions, and its covariance.
  struct Part {
    Eigen::Matrix3d covariance;
    EffectContribution words;
  };

  Part ChannelPart(const std::string& channel, const Eigen::MatrixXd& gain) const;
  Part SharedPart(const Eigen::MatrixXd& gain, double pair_sigma_m) const;

  std::vector<Source> sources_;  // those of a channel one after another
};

/// Returns the moments of forms of the residuals if the other `channels` have this noise beyond the
/// stated one. The noise of the own channel of a form is as stated. They are those of 32 samples.
std::vector<FormMoments> MomentsWithNoise(const std::vector<ResidualForm>& forms,
                                          const Marginals& marginals, const NoiseBeyondModel& noise,
                                          const std::vector<std::string>& channels);

}  // namespace dn::diagnosis_internal
