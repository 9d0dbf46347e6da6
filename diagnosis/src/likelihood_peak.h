#pragma once

#include <functional>
#include <optional>
#include <vector>

namespace dn::diagnosis_internal {

/// Function that returns the log likelihoods of several sizes, given by their logarithms.
using SizeLikelihoods = std::function<std::vector<double>(const std::vector<double>&)>;

/// The most probable size, as the maximum of a normal likelihood of its logarithm.
struct LikelihoodPeak {
  double log_size = 0.0;
  double value = 0.0;  ///< log likelihood at this size
  double width = 0.0;  ///< standard deviation of log_size, from the curvature
};

/// Finds the most probable size. If all errors have one size, their log likelihood over x =
/// ln(size) is
///
///   l = a - n x - S exp(-2x)
///
/// This function is fitted to three places, and fitted again with its maximum as a new place, until
/// the likelihood there agrees with the prediction. The width follows from places one width to
/// either side. Returns nullopt if the likelihood has no maximum between `low` and `high`, or if
/// the search fails. May evaluate a place more than once.
///
/// `first` are the logarithms to start with: at least three, ascending, between `low` and `high`.
std::optional<LikelihoodPeak> FindPeak(const SizeLikelihoods& likelihood,
                                       const std::vector<double>& first, double low, double high);

}  // namespace dn::diagnosis_internal
