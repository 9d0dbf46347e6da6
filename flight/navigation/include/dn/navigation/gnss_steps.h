#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <vector>

namespace dn {

/// A common offset of a run of consecutive GNSS epochs.
struct GnssJump {
  std::size_t first = 0;  ///< indices into FlightNetwork::gnss().edges(), both included
  std::size_t last = 0;
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  ///< map axes
  double statistic = 0.0;                              ///< chi-square of three
};

/// Returns the most significant common offset of a run of active GNSS positions, from score tests.
/// The candidates are runs that begin and end at positions in `ends`, those that contradict the
/// others most. Their ends are then moved to the best place. Returns nullopt unless the test is
/// decisive and the offset exceeds four sigmas of a single epoch. A smaller offset may be slow GNSS
/// drift, which does not justify leaving out the epochs. `noise_ratio`: as for
/// GnssScreening::Apply.
std::optional<GnssJump> FindGnssJump(const FlightNetwork& network, const Marginals& marginals,
                                     const std::vector<FactorId>& ends, double noise_ratio = 1.0);

/// A single cause that explains the misfit of the GNSS epochs.
struct GnssMisfit {
  enum class Cause {
    kLeverArm,   ///< `estimate`: correction of the lever arm, body axes, m
    kClock,      ///< `estimate`: delay (s) and its drift (s/s) of the GNSS tags, see ClockEstimate
    kClockStep,  ///< `estimate`: delay of the GNSS tags from `first` on, s
  };
  Cause cause = Cause::kLeverArm;
  Eigen::VectorXd estimate;  ///< first-order estimate, see Cause
  double statistic = 0.0;
  std::size_t first = 0;  ///< index into FlightNetwork::gnss().edges()
};

/// Returns the number of epochs between two places where a step of the clock is tested.
std::size_t StepSpacing(std::size_t epochs);

/// Returns the single cause of the misfit of the GNSS positions and velocities, from score tests,
/// or nullopt if no test is decisive.
///
/// If several causes are decisive, the result is the one with the largest statistic. A step of the
/// clock is considered only if offset and drift are not significant. A lever arm or a step must
/// explain at least half of the excess of the squared residuals. It must also move a GNSS epoch by
/// more than four sigmas. A smaller effect may be part of slow GNSS drift. An offset with a drift
/// need not fulfil this: estimating them does no harm, and other causes are then judged better.
/// Causes that are already estimated are not tested, nor are steps unless `clock_may_step`. The
/// estimate of a step is of first order in time: an adjustment with corrected tags must confirm it.
std::optional<GnssMisfit> ExplainGnssMisfit(const FlightNetwork& network,
                                            const Marginals& marginals, bool clock_may_step = true);

}  // namespace dn
