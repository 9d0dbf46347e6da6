#pragma once

#include <cstddef>
#include <filesystem>

namespace dn::testing {

/// The page of a result is small enough to be sent, and every number of it that says where it comes
/// from, at least `least` of them, is that of the file that it names.
void ExpectPageOfItsFiles(const std::filesystem::path& folder, std::size_t least);

}  // namespace dn::testing
