#pragma once

#include <dn/report/json.h>
#include <dn/sim/own_errors.h>
#include <dn/sim/random.h>
#include <dn/sim/simulate.h>

#include <string>
#include <vector>

namespace dn {

/// Physics that no effect of the table describes, with the numbers of one flight.
struct Outsider {
  std::string name;
  Json parameters;  ///< their keys carry the units
};

/// scan_torsion, strip_range_jump, gyro_oscillation, gnss_waves, boresight_warming,
/// boresight_by_heading, matcher_shift, lidar_clock_walk.
std::vector<std::string> OutsiderNames();

/// Draws the numbers of an outsider: its size between 1 and 10 times the usual one of the nearest
/// effect, in the logarithm, with random signs and axes. Throws InvalidInput for an unknown name.
Outsider DrawOutsider(const std::string& name, const FlightTimes& times, Random& random);

/// What the simulation does with it; `scenario`: the axes of its scanner. Throws InvalidInput for an
/// unknown name, Json::exception for parameters that are not those of the name.
OwnErrors MakeOwnErrors(const Outsider& outsider, const Scenario& scenario);

/// 10^x with x uniform: between low and high, both positive.
double LogUniform(double low, double high, Random& random);

/// One of 0 .. count - 1.
std::size_t DrawIndex(std::size_t count, Random& random);

/// A value of one to three axes and of this size, with random signs: as often along a single axis
/// as along all, there with at least half the size on each.
std::vector<double> DrawAxes(std::size_t axes, double size, Random& random);

}  // namespace dn
