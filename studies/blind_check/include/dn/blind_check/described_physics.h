#pragma once

#include <dn/blind_check/outsider.h>

#include <string>
#include <vector>

namespace dn {

/// Kind of error that a file describes (docs/reference/physics.md), so that a series can contain
/// physics that this program has never seen. The error is an amplitude times a shape, which is a
/// function of one argument.
struct DescribedPhysics {
  std::string name;
  std::string adds_to;  ///< quantity with the error; the name ends with its unit
  double size = 0.0;    ///< least amplitude, in this unit; amplitudes are 1 to 10 times this
  std::string shape;
  std::string of;                      ///< argument of the shape
  double lowest = 0.0, highest = 0.0;  ///< range of the parameter of the shape, if it has one
};

/// Reads the list `physics` of a YAML text; messages name it `file`. Throws InvalidConfig with the
/// location of the error, also for a name that an effect of the library or another entry has.
std::vector<DescribedPhysics> ParsePhysics(const std::string& text, const std::string& file);

/// Draws the amplitude (random signs and axes, log-uniform size) and the parameter of the shape
/// (log-uniform for periods and time constants, uniform for a position).
UnlistedEffect DrawDescribedPhysics(const DescribedPhysics& physics, const FlightTimes& times,
                                    Random& random);

/// Returns true for the parameters of a drawn effect of a file.
bool IsDescribed(const Json& parameters);

/// Returns the errors that the simulation adds. Throws InvalidInput for an unknown word and
/// Json::exception for missing parameters.
OwnErrors MakeDescribedErrors(const Json& parameters, const Scenario& scenario);

}  // namespace dn
