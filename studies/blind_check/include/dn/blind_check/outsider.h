#pragma once

#include <dn/report/json.h>
#include <dn/sim/own_errors.h>
#include <dn/sim/random.h>
#include <dn/sim/simulate.h>

#include <string>
#include <vector>

namespace dn {

/// An effect outside the library of effects, with its parameters in one flight.
struct UnlistedEffect {
  std::string name;
  Json parameters;  ///< their keys carry the units
};

/// Returns scan_torsion, strip_range_jump, gyro_oscillation, gnss_waves, boresight_warming,
/// boresight_by_heading, matcher_shift, lidar_clock_walk.
std::vector<std::string> UnlistedEffectNames();

/// Draws the parameters of an effect, with random signs and axes. The size is log-uniform between 1
/// and 10 times the typical size of the most similar effect in the library. Throws InvalidInput for
/// an unknown name.
UnlistedEffect DrawUnlistedEffect(const std::string& name, const FlightTimes& times,
                                  Random& random);

/// Returns the errors that the simulation adds for the effect, also for one that a file describes.
/// The scanner axes are those of `scenario`. Throws InvalidInput for an unknown name,
/// Json::exception for wrong parameters.
OwnErrors MakeOwnErrors(const UnlistedEffect& outsider, const Scenario& scenario);

/// Draws a number whose logarithm is uniform between those of low and high, which are positive.
double LogUniform(double low, double high, Random& random);

/// Draws an integer from 0 to count - 1.
std::size_t DrawIndex(std::size_t count, Random& random);

/// Draws a vector of one to three axes with random signs. In half of the cases it has this size
/// along one axis. Otherwise each component is 0.5 to 1 times the size.
std::vector<double> DrawAxes(std::size_t axes, double size, Random& random);

}  // namespace dn
