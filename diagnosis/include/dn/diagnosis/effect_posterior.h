#pragma once

#include <dn/effects/effect_table.h>
#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Joint posterior of the fixed effects e that a model leaves out, and of the calibration unknowns
/// x, SI. The first unknowns are those of the boresight (left rotation). The effects under
/// `estimate` follow in the order of UnmodelledEffects::unknowns, then others, among them the tie
/// points of the network.
struct EffectPosterior {
  std::vector<EffectId> effect;         ///< one per element of e
  std::vector<Eigen::Index> component;  ///< index within the effect, one per element of e
  Eigen::VectorXd prior_sigma;          ///< prior standard deviations of e
  Eigen::VectorXd estimate;             ///< posterior mean of e
  Eigen::MatrixXd covariance;           ///< posterior covariance of e
  Eigen::MatrixXd added;       ///< covariance that these effects, and the process of GNSS, add to x
  Eigen::MatrixXd cross;       ///< covariance of x (rows) with e (columns)
  Eigen::VectorXd change;      ///< of x, by these effects and the process of GNSS
  Eigen::Index first_tie = 0;  ///< first row of the tie points in x, three per point
};

}  // namespace dn
