#pragma once

namespace dn::internal {

/// A signature is absorbed by the unknowns if they leave less than this share of its squared length:
/// that is rounding error.
inline constexpr double kAbsorbedShare = 1e-7;

/// Returns the minimal detectable bias (Baarda, see OutlierTest) in units of the signature. It is
/// infinite if the unknowns absorb the signature.
double MinimalDetectableBias(double information, double signature2);

}  // namespace dn::internal
