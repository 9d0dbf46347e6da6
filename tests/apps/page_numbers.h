#pragma once

#include <cstddef>
#include <filesystem>

namespace dn::testing {

/// Expects that the page of a result is small enough to be sent by mail. Also expects at least
/// `least` numbers with a source, each equal to the value in the file that it names.
void ExpectPageMatchesFiles(const std::filesystem::path& folder, std::size_t least);

}  // namespace dn::testing
