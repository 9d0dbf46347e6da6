#pragma once

#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/pairs.h>

#include <cstddef>
#include <filesystem>
#include <vector>

namespace dn::lidar_internal {

inline constexpr std::size_t kEndColumns = 8;

/// Returns the ends of a pair from the first eight columns of a row: t_i, t_j, u_i (3), u_j (3).
/// Throws InvalidInput, with `where`, for a time or vector that ReadPairs refuses.
LidarPair ReadEnds(const double* row, int file, const FileLocation& where);

/// Calls take(row, columns, where) for each row of a file with one of these numbers of columns.
/// `time_offset_s` is subtracted from the epochs first, the first two columns.
template <class Take>
void ForEachPairRow(const std::filesystem::path& path, const std::vector<std::size_t>& columns,
                    double time_offset_s, const Take& take) {
  TextTable table = ReadTextTable(path, columns);
  FileLocation where{path.string(), 0, 0};
  for (std::size_t i = 0; i < table.rows(); ++i) {
    where.line = table.lines[i];
    for (std::size_t c = 0; c < 2; ++c) table.values[i * table.columns + c] -= time_offset_s;
    take(table.row(i), table.columns, where);
  }
}

}  // namespace dn::lidar_internal
