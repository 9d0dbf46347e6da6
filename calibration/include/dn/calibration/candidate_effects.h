#pragma once

#include <dn/builder/flight_network.h>
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
  EffectModel model;        ///< d residual / d component, SI
};

/// Every effect that the network can be tested for and has not among its unknowns: those of GNSS
/// and of the inertial sensors, and of the lidar where the network has pairs.
///
/// The derivatives are those of the assumed model at the present values. Effects on the raw
/// inertial data enter by the means of rate and specific force over each edge: exact to first order
/// for the attitude and velocity of an edge, which carry nearly all of their information. What they
/// change in the partial increments of a pair is left out.
std::vector<CandidateEffect> CandidateEffects(const FlightNetwork& network);

}  // namespace dn
