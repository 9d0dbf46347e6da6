#pragma once

namespace dn {

/// A conversion from the unit of a configuration key to SI.
using ToSi = double (*)(double);

/// Converts deg to rad.
double RadFromDeg(double deg);

/// Returns the value in the unit of the key that `to_si` converts exactly to `si`. If there are
/// several, it is the one with the fewest decimal digits; if there is none, the nearest value.
/// `to_si` must be a multiplication by a constant.
double InUnit(double si, ToSi to_si);

}  // namespace dn
