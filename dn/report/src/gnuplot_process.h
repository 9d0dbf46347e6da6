#pragma once

#include <functional>
#include <optional>
#include <string>

namespace dn::internal {

/// What gnuplot prints for a script. Nothing where it cannot be started, fails, takes longer than
/// 20 s, or is ended because `interrupted` became true.
std::optional<std::string> RunGnuplot(const std::string& script,
                                      const std::function<bool()>& interrupted);

/// Kills the gnuplot that runs; none is started any more.
void ForbidGnuplot() noexcept;

}  // namespace dn::internal
