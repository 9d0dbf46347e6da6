#pragma once

#include <dn/builder/calibration_effect.h>
#include <dn/builder/flight_network.h>
#include <dn/flight/effect_times.h>
#include <dn/solvers/score_test.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// Something that the data of a flight may contain and its network lacks.
struct CandidateEffect {
  std::string name;         ///< as in `effects:` of a scenario and `estimate:` of a flight
  std::string unit;         ///< of reported values
  double per_si = 1.0;      ///< reported = SI value * per_si
  Eigen::VectorXd typical;  ///< usual size of each component, SI
  std::string remedy;       ///< what to correct or to estimate, naming the keys
  EffectTimes times;        ///< when it is there
  EffectModel model;        ///< d residual / d component, SI
};

/// An effect of the estimator, without its model.
CandidateEffect DescribeEffect(const EstimableEffect& effect);

/// An effect of one's own that is looked for beside those of the estimator.
struct OwnEffect {
  std::string name;
  EffectAction action;
  Eigen::VectorXd typical;  ///< usual size of each component, SI
};

/// Every effect that the network can be tested for and has not among its unknowns: those of GNSS
/// and of the inertial sensors, and of the lidar where the network has pairs. A step of the
/// boresight is one candidate for every time between two strips.
///
/// The derivatives are those of the factors that estimate the effect, at the present values. `own`
/// ones come last, in their order; of those that touch no factor the model is empty.
std::vector<CandidateEffect> CandidateEffects(const FlightNetwork& network, int threads = 1,
                                              const std::vector<OwnEffect>& own = {});

}  // namespace dn
