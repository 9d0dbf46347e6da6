#pragma once

#include <dn/builder/calibration_effect.h>
#include <dn/builder/flight_network.h>
#include <dn/files/effect_times.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// An effect that may be present in the data of a flight but is not modelled in its network.
struct CandidateEffect {
  std::string name;         ///< as in `effects:` of a scenario and `estimate:` of a flight
  std::string unit;         ///< unit of reported values
  double per_si = 1.0;      ///< reported = SI value * per_si
  Eigen::VectorXd typical;  ///< typical size of each component, SI
  std::string remedy;       ///< proposed correction or estimate, with the keys' names
  EffectTimes times;        ///< the times at which it acts
  EffectModel model;        ///< d residual / d component, SI
};

/// Returns an effect of the estimator as a candidate with an empty model.
CandidateEffect DescribeEffect(const EstimableEffect& effect);

/// A user-defined effect that is tested in addition to those of the estimator.
struct UserEffect {
  std::string name;
  EffectAction action;
  Eigen::VectorXd typical;  ///< typical size of each component, SI
};

/// Returns every effect that the network can be tested for and does not estimate. These are GNSS
/// effects, inertial effects and, with pairs, lidar effects. For a step of the boresight there is
/// one candidate per time between two strips, six at most.
///
/// The derivatives are those of the factors that estimate the effect, at the present values. The
/// effects in `own` come last, in their order; the model of one that acts on no factor is empty.
std::vector<CandidateEffect> CandidateEffects(const FlightNetwork& network, int threads = 1,
                                              const std::vector<UserEffect>& own = {});

}  // namespace dn
