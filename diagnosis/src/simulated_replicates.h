#pragma once

#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>
#include <dn/sim/scenario.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "locations.h"
#include "replicates.h"

namespace dn::diagnosis_internal {

/// Statistics of one flight by the name that StatisticName returns.
using NamedStatistics = std::map<std::string, double>;

/// Returns the statistics that a flight and its replay share: of the whole flight, and of pairs of
/// strips.
NamedStatistics Comparable(const std::vector<LocationStatistic>& statistics,
                           const Eigen::VectorXd& values);

/// Copies the settings that a replicate shares with its flight from `of` to `config`. The
/// replicate's own flight.yaml does not state vibration, which is an effect of its scenario.
void CopyAssumptions(const FlightConfig& of, FlightConfig* config);

struct SimulatedReplicateOptions {
  int count = 8;
  std::uint64_t seed = 1;
  int threads = 1;  ///< replicates made in parallel
  std::function<bool()> interrupted = {};
};

/// Simulates replicates from raw data on, each with its own noise, and adjusts them by the assumed
/// model of `flight`. They include raw data, outliers and nonlinearity. Leaves out replicates that
/// cannot be adjusted. Throws Interrupted, and as Simulate for the scenario.
std::vector<NamedStatistics> SimulateReplicates(const Flight& flight, const Scenario& scenario,
                                                const Trajectory& replayed,
                                                const SimulatedReplicateOptions& options);

/// Statistics of the linear replicates by name.
struct LinearReplicates {
  NamedStatistics mean, sigma;  ///< over the first half
  std::vector<NamedStatistics> all;
};
/// Returns the statistics of linear replicates by name.
LinearReplicates NameLinearReplicates(const std::vector<LocationStatistic>& statistics,
                                      const ReplicateSet& replicates, const ReplicateTest& test);

/// Returns the p-value of the energy distance of simulated and linear replicates of the assumed
/// model, by permutation. A small value means that linear replicates do not represent flights.
/// Returns nullopt with fewer than three simulated replicates.
std::optional<double> TestSimulatedAgainstLinear(const std::vector<NamedStatistics>& full,
                                                 const LinearReplicates& linear,
                                                 std::uint64_t seed);

/// Returns the p-value of the flight as one more simulated replicate with the effects. It uses the
/// statistics in which the flight differs most from the assumed model; each replicate is judged by
/// its own. Standard deviations and correlations are those of the linear replicates, or larger if
/// the simulated ones vary more. A quarter of the change caused by the effects may come from the
/// ground of the replicates, which differs from that of the flight. Returns nullopt with fewer than
/// three replicates.
std::optional<double> TestAmongReplicates(const NamedStatistics& flight,
                                          const std::vector<NamedStatistics>& replicates,
                                          const LinearReplicates& linear, std::uint64_t seed);

/// Mean and standard deviation of a statistic over the replicates that have it.
struct MeanAndSigma {
  double mean = 0.0, sigma = 0.0;
};
/// Returns nullopt if fewer than two replicates have the statistic.
std::optional<MeanAndSigma> ReplicateMeanAndSigma(const std::vector<NamedStatistics>& replicates,
                                                  const std::string& name);

}  // namespace dn::diagnosis_internal
