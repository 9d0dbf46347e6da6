#pragma once

#include <dn/flight/flight.h>
#include <dn/geo/trajectory.h>
#include <dn/sim/scenario.h>

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "locations.h"
#include "twins.h"

namespace dn::internal {

/// Statistics of one flight by name (NameOf).
using NamedStatistics = std::map<std::string, double>;

/// Those that a flight and its replay have in common: of the whole flight, and of pairs of strips.
NamedStatistics Comparable(const std::vector<LocationStatistic>& statistics,
                           const Eigen::VectorXd& values);

/// What a twin's flight.yaml says as that of the flight does. Vibration that the flight states is an
/// effect of the twin's scenario, whose flight.yaml does not state it.
void AssumeAs(const FlightConfig& of, FlightConfig* config);

struct FullTwinOptions {
  int count = 8;
  std::uint64_t seed = 1;
  int threads = 1;  ///< so many twins side by side
  std::function<bool()> interrupted = {};
};

/// Flights simulated anew, each with noise of its own, and adjusted by the assumed model of
/// `flight` like the flight itself: raw data, gross errors and all that is not linear take part. A
/// twin that cannot be adjusted is missing. Throws Interrupted, and as Simulate for the scenario.
std::vector<NamedStatistics> FlyTwins(const Flight& flight, const Scenario& scenario,
                                      const Trajectory& replayed, const FullTwinOptions& options);

/// A statistic of the linear twins, or of the flight, by name.
struct LinearTwins {
  NamedStatistics mean, sigma;  ///< of the first half
  std::vector<NamedStatistics> all;
};
LinearTwins NamedLinearTwins(const std::vector<LocationStatistic>& statistics, const Twins& twins,
                             const TwinTest& test);

/// p of the energy distance of simulated and linear twins of the assumed model, by permutation:
/// small where the linear ones cannot stand for flights. Nothing with fewer than three.
std::optional<double> FullAgainstLinear(const std::vector<NamedStatistics>& full,
                                        const LinearTwins& linear, std::uint64_t seed);

/// p of the flight as one more of the simulated twins with the effects, by the statistics in which
/// it departs most from the assumed model; each twin is judged by those in which it does. Their scatter and correlation are those of the linear
/// twins, or wider where the simulated ones scatter more; a quarter of what the effects change may
/// come from the ground of the twins, which is not that of the flight. Nothing with fewer than three.
std::optional<double> LikeTwins(const NamedStatistics& flight,
                                const std::vector<NamedStatistics>& twins,
                                const LinearTwins& linear, std::uint64_t seed);

/// Mean and standard deviation of a statistic over the twins that have it.
struct MeanAndSigma {
  double mean = 0.0, sigma = 0.0;
};
std::optional<MeanAndSigma> MeanOver(const std::vector<NamedStatistics>& twins,
                                     const std::string& name);

}  // namespace dn::internal
