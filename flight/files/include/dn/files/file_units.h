#pragma once

namespace dn {

/// Conversion from the unit of a configuration key to SI.
using ToSi = double (*)(double);

/// rad from deg.
double RadFromDeg(double deg);

/// The value in the key's unit that `to_si` converts to exactly `si`, the shortest one in decimal
/// when there are several. `to_si` is a multiplication by a constant. Where no double converts
/// exactly the nearest one is returned.
double InUnit(double si, ToSi to_si);

}  // namespace dn
