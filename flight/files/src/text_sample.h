#pragma once

#include <dn/geo/text_table.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "date_column.h"

namespace dn::files_internal {

/// Rows of a text of any columns. Fields that are neither finite numbers nor
/// calendar times of ISO 8601 are NaN.
struct TextSample {
  std::vector<std::string> names;      ///< of the columns, from a header; empty if there is none
  std::vector<std::string> first_row;  ///< its fields
  TextTable table;                     ///< calendar times of ISO 8601 are GPS seconds since 1980
  /// A date apart from the time of day. `table` then has GPS seconds since 1980 in place of the
  /// time.
  std::optional<DateColumn> date = {};
  /// True if the file has header lines or other separators, so that ReadTextTable does not read it.
  bool needs_names = false;
};

/// Reads the first rows of a text, at most max_rows. The names are those of a line before the first
/// row: the line with the most names of known meaning. It may begin with # or %. The last field of
/// a row may be missing; other rows with fewer fields are left out unless they end with a tab.
/// Throws InvalidInput if no line has a number in its first two fields, and for fewer than 4
/// columns.
TextSample ReadTextSample(const std::filesystem::path& file, std::size_t max_rows);

}  // namespace dn::files_internal
