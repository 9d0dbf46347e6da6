#include "spaced_rows.h"

namespace dn::files_internal {
namespace {

// With this limit, a day at 200 Hz keeps some rows of every half minute.
constexpr std::size_t kMostSpacedRows = 50000;

void AppendRow(const TextTable& from, std::size_t row, TextTable* to) {
  to->columns = from.columns;
  to->values.insert(to->values.end(), from.row(row), from.row(row) + from.columns);
  to->lines.push_back(from.lines[row]);
}

TextTable EverySecondRow(const TextTable& table) {
  TextTable kept;
  kept.file = table.file;
  for (std::size_t i = 0; i < table.rows(); i += 2) AppendRow(table, i, &kept);
  return kept;
}

}  // namespace

TextTable ReadSpacedRows(const std::filesystem::path& file, std::size_t part) {
  TextTableReader reader(file, {});
  TextTable rows;
  rows.file = file;
  std::size_t step = 1, skipped = 0;
  while (reader.Next(part)) {
    for (std::size_t i = 0; i < reader.table().rows(); ++i) {
      if (skipped > 0) {
        --skipped;
        continue;
      }
      AppendRow(reader.table(), i, &rows);
      if (rows.rows() >= kMostSpacedRows) {
        rows = EverySecondRow(rows);
        step *= 2;
      }
      skipped = step - 1;
    }
  }
  return rows;
}

}  // namespace dn::files_internal
