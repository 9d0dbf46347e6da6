#pragma once

namespace dn::testing {

/// A normal variable exceeds this many sigmas with probability 6e-5.
inline constexpr double kSigmas = 4.0;

}  // namespace dn::testing
