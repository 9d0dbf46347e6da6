#pragma once

#include <dn/error.h>
#include <dn/geo/read_file.h>
#include <dn/geo/week_seconds.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace dn {

/// Numbers of a text file, row by row, with where each row stood.
struct TextTable {
  std::filesystem::path file;
  std::size_t columns = 0;
  std::vector<double> values;  ///< row-major, rows() x columns
  std::vector<long> lines;     ///< line number (from 1) of each row

  std::size_t rows() const { return lines.size(); }
  const double* row(std::size_t i) const { return values.data() + i * columns; }
};

/// Reads a numeric table: values separated by commas, blanks or tabs; '#' (and `comment`) starts a
/// comment; blank lines are skipped; CRLF is accepted. Every row must have the same number of
/// columns, one of `allowed_columns` (empty: any). Throws InvalidInput naming file:line:column for
/// a missing file, one that is no regular file, an empty file, a value that is no number, NaN or
/// infinity, semicolons, decimal commas, and a wrong number of columns (saying which numbers are
/// right). The rows after the first most_rows are left unread.
TextTable ReadTextTable(const std::filesystem::path& file,
                        const std::vector<std::size_t>& allowed_columns, char comment = '#',
                        std::size_t most_rows = SIZE_MAX);

/// Reads what ReadTextTable reads, in parts: of a file of any length only one part is held.
class TextTableReader {
 public:
  TextTableReader(const std::filesystem::path& file, std::vector<std::size_t> allowed_columns,
                  char comment = '#');

  /// Reads the next rows, at most so many, in place of those before; false after the last. Throws
  /// as ReadTextTable.
  bool Next(std::size_t most_rows);

  const TextTable& table() const& { return table_; }
  TextTable table() && { return std::move(table_); }

 private:
  LineReader lines_;
  std::vector<std::size_t> allowed_columns_;
  char comment_;
  TextTable table_;
};

/// A time column in GPS seconds of week: a backward jump of a week, to within an hour, is a
/// rollover and is continued (604800 s added from there on).
///
/// `keep` receives the rows to keep: rows identical to the row before are dropped. Any other repeat
/// or step back throws InvalidInput naming the line, as does a time that is no seconds of week
/// (CheckSecondsOfWeek). Returns the number of dropped rows. Column 0 holds the time, from which
/// time_offset_s is taken before all else.
long ContinueAndCheckTimes(TextTable& table, std::vector<std::size_t>& keep,
                           double time_offset_s = 0.0);

/// A finite number that takes up all of `text` (a leading '+' is accepted). Throws InvalidInput at
/// `where`.
double ParseNumber(std::string_view text, const FileLocation& where);

/// Shortest text of a double that reads back to the same bits (at most 17 significant digits).
std::string FormatDouble(double value);

}  // namespace dn
