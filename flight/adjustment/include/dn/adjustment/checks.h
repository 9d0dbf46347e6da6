#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// Residuals of one kind against what their redundancy lets them be. p-values hold for the family:
/// they are multiplied by the number of tests of the model check.
struct GroupCheck {
  std::string name;                   ///< "lidar p2p", "inertial gyro", "gnss position east" ...
  long observations = 0;              ///< residuals
  double redundancy = 0.0;            ///< what the fit leaves of them
  double variance_ratio = 1.0;        ///< sum of squares / redundancy
  double ratio_beside_effects = 1.0;  ///< the same with the effects found among the unknowns
  double p_value = 1.0;               ///< of a ratio this far from 1, either way
  double worst_t_s = 0.0;
  double worst_standardised = 0.0;  ///< residual / root of its redundancy number
};

/// Residuals that may share errors: the sum over windows of the squared sum of their residuals.
struct CommonErrorCheck {
  std::string name;      ///< "gnss position, over 60 s" ...
  std::string group;     ///< whose residuals
  std::string worst;     ///< of pairs of strips: those that disagree most, where significant
  double ratio = 1.0;    ///< of that sum to its expectation
  double p_value = 1.0;  ///< of a ratio this large
  double sigma = 0.0;    ///< of the common error, in sigmas of one residual; 0 where none shows
  double damage = 0.0;   ///< largest move of a watched unknown by such errors, in its sigmas
  double log_evidence = 0.0;  ///< nats, for a common error of the likeliest size against none
  bool explained = false;     ///< no longer significant beside the effects found
};

/// An effect that the data show and the network lacks, by a score test: to first order.
struct EffectCheck {
  std::string name;
  std::string unit;
  std::string remedy;
  double p_value = 1.0;
  double log_evidence = 0.0;  ///< nats, against its absence, at sizes around the usual one
  Eigen::VectorXd estimate;   ///< in `unit`, beside the effects before it
  Eigen::VectorXd sigma;
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< move of the boresight by it
  double damage = 0.0;  ///< largest move of a watched unknown, in its sigmas
  std::vector<std::string> inseparable_from;
};

/// A way in which the data depart from the model that no effect of the table is: a score test beside
/// the effects found, against the noise that the pairs show where that is above the stated one.
struct DepartureCheck {
  std::string name;  ///< "laser vectors by scan angle" ...
  double statistic = 0.0;
  int dof = 0;
  double p_value = 1.0;
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< move of the boresight by what shows
  double damage = 0.0;  ///< largest move of a watched unknown by it, in its sigmas
};

/// An effect that in its usual size would move a watched unknown by more than its sigma, and that the
/// data would not show: of its components the one that moves it farthest, by itself.
struct UnseenEffect {
  std::string name;
  std::string component;            ///< "x", "east"; empty where there is one only
  std::string unit;                 ///< of both sizes
  double usual = 0.0;               ///< 1 sigma of what is to be expected
  double minimal_detectable = 0.0;  ///< Baarda's (RowTest), to first order; infinite: no size shows
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< move of the boresight at `usual`
  double damage = 0.0;  ///< there, of the watched unknown that moves farthest, in its sigmas
};

/// An effect that explains the data as well as an unknown that is estimated: of all that do, the one
/// that moves the watched unknowns farthest in its place.
struct RivalCheck {
  std::string unknown, rival;
  double log_evidence = 0.0;  ///< nats, of the rival against the unknown
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< with the rival, from that without
  double damage = 0.0;  ///< largest move of a watched unknown, in its sigmas
};

/// A stated prior of an unknown against what all other data say of it.
struct PriorCheck {
  std::string unknown;
  double statistic = 0.0;
  int dof = 0;
  double p_value = 1.0;
};

}  // namespace dn
