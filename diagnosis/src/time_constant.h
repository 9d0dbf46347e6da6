#pragma once

#include <functional>
#include <optional>

namespace dn::internal {

/// The likeliest size of a process with one time constant.
struct SizeAtTau {
  double size = 1.0;            ///< in usual ones
  double relative_sigma = 0.3;  ///< of a normal likelihood of its logarithm
  double log_likelihood = 0.0;  ///< there, against a process that is as good as absent
};

/// By the time constant in seconds; nothing where there is no such network.
using SizesByTau = std::function<std::optional<SizeAtTau>(double tau_s)>;

/// Size and time constant of a process. Their standard deviations are those whose intervals of 95 %
/// reach as far as that of the likelihood does on its longer side.
struct ProcessEstimate {
  double size = 1.0, sigma_of_size = 0.0;    ///< in usual ones
  double tau_s = 0.0, sigma_of_tau_s = 0.0;  ///< NaN: the time constant does not show
};

/// The maximum of the likelihood of size and time constant, searched for from `tau_s` on in steps of
/// equal factors. Both are uncertain by factors, and more so upwards: in a short flight a long time
/// constant is hardly told from a longer one, and the size goes with it. The interval ends where the
/// logarithm of the likelihood has fallen by 1.96^2 / 2, or at 1.6^4 times the time constant where it does
/// not fall so far. Nothing where there is no network at the time constants beside `tau_s`.
std::optional<ProcessEstimate> LikeliestProcess(const SizesByTau& sizes, double tau_s);

}  // namespace dn::internal
