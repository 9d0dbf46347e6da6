#pragma once

#include <functional>
#include <optional>
#include <string>

namespace dn::internal {

/// What gnuplot prints for a script. Nothing where it cannot be started, fails, takes longer than
/// 20 s, or is ended because `interrupted` became true.
std::optional<std::string> RunGnuplot(const std::string& script,
                                      const std::function<bool()>& interrupted);

/// Process id of the gnuplot that runs, 0: none.
int GnuplotProcess() noexcept;

}  // namespace dn::internal
