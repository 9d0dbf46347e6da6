#pragma once

#include <dn/calibration/adjust.h>
#include <dn/calibration/result.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <optional>
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

/// A stated prior of an unknown against what all other data say of it.
struct PriorCheck {
  std::string unknown;
  double statistic = 0.0;
  int dof = 0;
  double p_value = 1.0;
};

/// What speaks for or against the assumed model, as a kind and its words.
struct Finding {
  enum class Kind {
    kEffect,       ///< an unmodelled effect is significant
    kVariance,     ///< residuals of a group are larger than stated
    kCommonError,  ///< residuals share errors that are taken as independent
    kSigma0,
    kPairsLeftOut,
    kGnssLeftOut,
    kPrior,
    kMounting,    ///< boresight angles that no mounting has
    kAttitude,    ///< the body flies upside down
    kTrajectory,  ///< the stage without pairs had found something
  };
  Kind kind;
  bool contradicts;  ///< the results must not be relied on
  double evidence;   ///< nats for it as the cause; infinite where there is no other
  std::string text;  ///< what, how much, and what to do
};

/// Whether the data of an adjusted flight are those that the assumed model would produce.
struct ModelCheck {
  bool of_boresight = false;  ///< what an effect moves is the boresight; else poses
  std::vector<GroupCheck> groups;
  std::vector<CommonErrorCheck> common_errors;
  std::vector<EffectCheck> effects;  ///< the significant ones, in the order found
  std::vector<PriorCheck> priors;
  double sigma0_beside_effects = 1.0;  ///< sigma0 with those among the unknowns, to first order
  double p_value = 1.0;                ///< smallest of all, for the family
  std::vector<Finding> findings;       ///< those that contradict first

  double SmallestPValue() const;  ///< of groups, common errors, effects and priors; 1 without any
  bool contradicted() const;
};

/// Tests an adjusted flight, without solving it again:
///
///   groups         r^T r of a group is a quadratic form of the errors with the mean tr(M_gg) (the
///                  sum of redundancy numbers) and the variance 2 tr(M_gg^2);
///   common errors  the same for sums of residuals over windows of time, and over pairs of strips;
///   effects        score tests of CandidateEffects, the likeliest first, each beside those before
///                  (the ratio of likelihoods over sizes around the usual one), with the move of
///                  the boresight that its estimate explains;
///   priors         predicted residual of each stated prior (PredictFactor);
///   shares of pairs and GNSS epochs that were left out, size of the boresight, sigma0.
///
/// tr(M_gg^2) and the moments of the sums over windows are those of 32 samples of M e, e ~ N(0, I),
/// of one fixed seed. p-values follow from the chi-square distribution of the same two moments.
///
/// A finding contradicts when it is significant at 0.001 for the family and moves the boresight
/// (without pairs: an attitude or a position) by more than its sigma, when a group has more than
/// twice its variance, sigma0 exceeds 3, more than 30 % of the pairs or 10 % of the GNSS epochs
/// were left out, a boresight angle exceeds 15 deg, or the body flies on its back.
///
/// `marginals` must be of the adjusted network with its selected inverse, `trajectory` what
/// ExtractTrajectory gave for both. CheckFit says the same of any network, as far as it can be said
/// without knowing what it is of.
ModelCheck CheckModel(const Adjustment& adjustment, const Marginals& marginals,
                      const TrajectoryResult& trajectory, int threads = 1);

/// The findings in words, those that contradict first.
std::vector<std::string> TextsOf(const ModelCheck& check);

/// Sets the verdict `contradicted` where the check says so, and puts what it found before the other
/// reasons.
void Assess(const ModelCheck& check, BoresightResult* boresight);

}  // namespace dn
