#pragma once

#include <functional>
#include <optional>

namespace dn::diagnosis_internal {

/// The most probable size of a process with one time constant.
struct LikelySize {
  double size = 1.0;            ///< in typical sizes
  double relative_sigma = 0.3;  ///< standard deviation of ln(size)
  double log_likelihood = 0.0;  ///< relative to a process that is practically absent
};

/// Function of the time constant in seconds; returns nullopt if the network cannot be built.
using SizesByTau = std::function<std::optional<LikelySize>(double tau_s)>;

/// Size and time constant of a process. The 95 % intervals of their standard deviations reach as
/// far as that of the likelihood on its longer side.
struct ProcessEstimate {
  double size = 1.0, size_sigma = 0.0;    ///< in typical sizes
  double tau_s = 0.0, tau_sigma_s = 0.0;  ///< NaN: undetermined
};

/// Returns the maximum of the likelihood of size and time constant, searched for from `tau_s` in
/// steps of equal factors. Both are uncertain by factors, and more so upwards: a short flight
/// hardly separates two long time constants, and the size depends on them. The interval ends where
/// the log likelihood has decreased by 1.96^2 / 2, or at 1.6^4 times the time constant if it
/// decreases less. Returns nullopt if the network cannot be built at a time constant of the search.
std::optional<ProcessEstimate> LikeliestProcess(const SizesByTau& sizes, double tau_s);

}  // namespace dn::diagnosis_internal
