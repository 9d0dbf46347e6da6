#pragma once

#include <functional>
#include <optional>
#include <string>

namespace dn::report_internal {

/// Returns the output of gnuplot for a script. Returns nullopt if it cannot be started, fails,
/// takes longer than 20 s, or is killed because `interrupted` returned true.
std::optional<std::string> RunGnuplot(const std::string& script,
                                      const std::function<bool()>& interrupted);

/// Kills a running gnuplot and prevents further ones.
void ForbidGnuplot() noexcept;

}  // namespace dn::report_internal
