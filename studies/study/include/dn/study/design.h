#pragma once

#include <dn/builder/build.h>
#include <dn/flight/flight.h>
#include <dn/sim/scenario.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace dn {

/// Where the states of a design come from.
enum class DesignSource { kScenario, kTrajectory, kInitialGuess, kInsGnss };

/// A flight as it is planned, or as it was flown: all that its covariances depend on.
struct StudyDesign {
  Flight flight;  ///< times of the epochs, and laser vectors of the pairs
  NetworkDesign states;
  std::vector<StripInterval> strips;
  DesignSource source = DesignSource::kScenario;
};

/// How a design is made.
struct DesignOptions {
  int threads = 1;
  std::uint64_t seed = 1;  ///< of turbulence and of the choice of pairs in a scenario
  /// What is free beside the boresight: elements of `estimate` of flight.yaml, joined by commas;
  /// empty: the boresight, and what the flight's own `estimate` names.
  std::string estimate;
  /// Of the trajectory nodes within the strips of a scenario; lower than network.node_rate_hz asks
  /// for, sigmas come out some percent off (docs/validation/benchmarks.md).
  double most_node_rate_hz = std::numeric_limits<double>::infinity();
  std::function<bool()> interrupted = {};  ///< polled; true ends the work with Interrupted
};

/// The unknowns of DesignOptions::estimate, with the boresight first. Throws InvalidConfig for a name
/// that is not that of an unknown, and names the nearest one.
std::vector<EstimateEntry> ParseEstimate(const std::string& list);

/// The flight that a scenario describes, with perfect sensors that state the scenario's noise. Of
/// its effects only the faults gnss_outage and imu_gap count, which are times without data. Throws
/// RankDeficient where no two strips see the same ground, or no pairs are wanted; InvalidConfig
/// where it cannot be flown or `estimate` is none.
StudyDesign DesignOf(const Scenario& scenario, const DesignOptions& options = {});

/// A flight on its trajectory, else on its initial guess, else on the INS/GNSS solution of its
/// data. Of a flight without inertial data, which is a plan, these are planned at 100 Hz on the
/// former two, and GNSS epochs at 1 Hz where it has a section `gnss` and none of its own. Throws
/// RankDeficient without pairs, InvalidInput where there is nothing to place the states on or no
/// section `imu`, InvalidConfig as above.
StudyDesign DesignOf(Flight flight, const DesignOptions& options = {});

}  // namespace dn
