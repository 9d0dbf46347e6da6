#pragma once

#include <string>

namespace dn {

/// Returns "46.8 +- 1.2" for a reader: both numbers are rounded to the second digit of the sigma,
/// and none has an exponent. If the sigma is not positive and finite, neither is rounded.
std::string FormatWithSigma(double value, double sigma, const char* plus_minus = "+-");

}  // namespace dn
