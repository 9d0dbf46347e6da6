#pragma once

#include <dn/geo/text_table.h>

#include <cstddef>
#include <filesystem>

namespace dn::files_internal {

/// Returns rows of the whole file, evenly spaced if the file has more than a fixed number of rows.
/// Reads the file in parts of `part` rows. Throws as TextTableReader does.
TextTable ReadSpacedRows(const std::filesystem::path& file, std::size_t part);

}  // namespace dn::files_internal
