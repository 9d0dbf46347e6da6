#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace dn {

/// An offset that a run of GNSS epochs has in common.
struct GnssJump {
  std::size_t first = 0;  ///< indices into FlightNetwork::gnss_edges, both included
  std::size_t last = 0;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  ///< in m
  double statistic = 0.0;                              ///< chi-square of three
};

/// The most significant common offset of a run of active GNSS positions, by score tests: of the
/// runs that begin and end at one of `ends` (positions that the others contradict most), their ends
/// then moved for the best. Nothing unless the test is beyond all doubt, and the offset more than
/// four times the sigma of a single epoch: less may be slowly wandering GNSS noise, which is no
/// reason to do without the epochs. `noise_ratio`: as for GnssScreening::Apply.
std::optional<GnssJump> FindGnssJump(const FlightNetwork& network, const Marginals& marginals,
                                     const std::vector<FactorId>& ends, double noise_ratio = 1.0);

/// One cause behind the misfit of all GNSS epochs.
struct GnssMisfit {
  enum class Cause {
    kLeverArm,   ///< estimate: correction of the lever arm in body, m
    kClock,      ///< offset (s) and drift (s/s) by which the GNSS tags are late, see ClockEstimate
    kClockStep,  ///< seconds by which they are late from `first` on
  };
  Cause cause = Cause::kLeverArm;
  Eigen::VectorXd estimate;  ///< to first order
  double statistic = 0.0;
  std::size_t first = 0;  ///< index into FlightNetwork::gnss_edges
};

/// The single cause behind the misfit of the GNSS positions and velocities, by score tests, if there
/// is one beyond all doubt: the one with the largest statistic, a step only where offset and drift
/// are none. A lever arm and a step must explain at least half of what all residuals have too much,
/// and move a GNSS epoch by more than four sigmas; without that they may be a part of what slowly
/// wandering GNSS noise does. An offset with a drift need not: to have them among the unknowns does
/// no harm, and the rest is judged better beside them. Causes that are estimated already are not
/// considered.
std::optional<GnssMisfit> ExplainGnssMisfit(const FlightNetwork& network,
                                            const Marginals& marginals);

}  // namespace dn
