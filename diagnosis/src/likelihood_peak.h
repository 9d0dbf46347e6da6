#pragma once

#include <functional>
#include <optional>
#include <vector>

namespace dn::internal {

/// Log likelihoods of several sizes, by their logarithms.
using SizeLikelihoods = std::function<std::vector<double>(const std::vector<double>&)>;

/// The likeliest size, as that of a normal likelihood of its logarithm.
struct LikelihoodPeak {
  double log_size = 0.0;
  double value = 0.0;  ///< there
  double width = 0.0;  ///< standard deviation by the curvature
};

/// The likeliest of the sizes asked for first, or one between them or beyond. Where errors of one
/// size make up all, their likelihood over x = ln(size) is
///
///   l = a - n x - S exp(-2x)
///
/// which is drawn through three places, and again with the likeliest so found, until it is what was
/// foretold; the width follows from places one width to either side. Nothing where the likelihood
/// has no maximum within low and high, or none is found. Asks again for places that it knows.
///
/// `first`: at least three, ascending, within low and high.
std::optional<LikelihoodPeak> FindPeak(const SizeLikelihoods& likelihood,
                                       const std::vector<double>& first, double low, double high);

}  // namespace dn::internal
