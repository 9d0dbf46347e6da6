#pragma once

#include <dn/builder/build.h>
#include <dn/files/flight.h>
#include <dn/sim/scenario.h>

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace dn {

/// Origin of the states of a design.
enum class DesignSource { kScenario, kTrajectory, kInitialGuess, kInsGnss };

/// A planned or flown flight, with everything that its covariances depend on.
struct StudyDesign {
  Flight flight;  ///< times of the epochs, and laser vectors of the pairs
  NetworkDesign states;
  std::vector<StripInterval> strips;
  DesignSource source = DesignSource::kScenario;
};

/// Options for making a design.
struct DesignOptions {
  int threads = 1;
  std::uint64_t seed = 1;  ///< seed of turbulence and of the choice of pairs in a scenario
  /// Unknowns estimated with the boresight: elements of `estimate` of flight.yaml, joined by
  /// commas. Empty: the boresight, and the unknowns in the flight's own `estimate`.
  std::string estimate;
  /// Section `unmodelled` of flight.yaml as YAML. Empty: that of the flight.
  std::string unmodelled;
  /// Upper limit of the rate of trajectory nodes within the strips of a scenario. Below
  /// network.node_rate_hz, sigmas are wrong by some percent (docs/validation/benchmarks.md).
  double max_node_rate_hz = std::numeric_limits<double>::infinity();
  std::function<bool()> interrupted = {};  ///< polled; returning true aborts with Interrupted
};

/// Returns the unknowns of DesignOptions::estimate, the boresight first. Throws InvalidConfig for a
/// name that is not an unknown; the message has the nearest one.
std::vector<EstimateEntry> ParseEstimate(const std::string& list);

/// Returns the flight that a scenario describes, with perfect sensors that state the scenario's
/// noise. Ignores its effects except gnss_outage and imu_gap, which are times without data. Throws
/// RankDeficient if no two strips overlap or if no pairs are requested. Throws InvalidConfig if the
/// scenario cannot be flown or if `estimate` is invalid.
StudyDesign MakeDesign(const Scenario& scenario, const DesignOptions& options = {});

/// Returns a flight on its trajectory, else on its initial guess, else on the INS/GNSS solution of
/// its data. A flight without inertial data is a plan on its trajectory or its initial guess. Its
/// inertial data are then planned at 100 Hz, and GNSS epochs at 1 Hz if it has a section `gnss` and
/// no epochs.
///
/// Throws RankDeficient for a flight without pairs. Throws InvalidInput if the states have no
/// source or if there is no section `imu`, and InvalidConfig if `estimate` is invalid.
StudyDesign MakeDesign(Flight flight, const DesignOptions& options = {});

}  // namespace dn
