#pragma once

#include <string>

namespace dn::files_internal {

/// Says what a file with a known signature is that is not read, and what to do with it; empty for
/// other files.
std::string KnownFileReason(const std::string& beginning);

}  // namespace dn::files_internal
