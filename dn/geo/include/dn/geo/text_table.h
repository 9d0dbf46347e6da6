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

/// Numbers of a text file, row by row, with the line number of each row.
struct TextTable {
  std::filesystem::path file;
  std::size_t columns = 0;
  std::vector<double> values;  ///< row-major, rows() x columns
  std::vector<long> lines;     ///< line number (from 1) of each row

  std::size_t rows() const { return lines.size(); }
  const double* row(std::size_t i) const { return values.data() + i * columns; }
};

/// Reads a numeric table. Values are separated by commas, blanks or tabs. At the beginning of a
/// line or after a separator, '#' (and `comment`) starts a comment. Blank lines are skipped; CRLF
/// is accepted. Every row must have the same number of columns, which must be one of
/// `allowed_columns` (empty: any). Rows after the first max_rows are not read. Throws InvalidInput
/// naming file:line:column for a file that is missing, empty or not regular. Also throws for a
/// value that is not a finite number, and for semicolons and decimal commas. For a wrong number of
/// columns, the message names the allowed numbers.
TextTable ReadTextTable(const std::filesystem::path& file,
                        const std::vector<std::size_t>& allowed_columns, char comment = '#',
                        std::size_t max_rows = SIZE_MAX);

/// Reads the same tables as ReadTextTable in parts, with only one part in memory.
class TextTableReader {
 public:
  TextTableReader(const std::filesystem::path& file, std::vector<std::size_t> allowed_columns,
                  char comment = '#');

  /// Replaces the table by the next rows, at most `max_rows`; returns false after the last row.
  /// Throws as ReadTextTable does.
  bool Next(std::size_t max_rows);

  const TextTable& table() const& { return table_; }
  TextTable table() && { return std::move(table_); }

 private:
  LineReader lines_;
  std::vector<std::size_t> allowed_columns_;
  char comment_;
  TextTable table_;
};

/// Makes a time column in GPS seconds of week continuous. A backward jump of a week, to within an
/// hour, counts as a week rollover: 604800 s are added from there on. time_offset_s is first
/// subtracted from column 0, the time.
///
/// `keep` receives the indices of the rows to keep; a row identical to the previous one is dropped.
/// Returns the number of dropped rows. Throws InvalidInput naming the line for any other repeated
/// or decreasing time, and for a time that cannot be seconds of week (CheckWeekSeconds).
long ContinueAndCheckTimes(TextTable& table, std::vector<std::size_t>& keep,
                           double time_offset_s = 0.0);

/// Parses a finite number that fills all of `text` (a leading '+' is accepted). Throws InvalidInput
/// at `where`.
double ParseNumber(std::string_view text, const FileLocation& where);

/// Returns the shortest text of a double that reads back to the same bits (at most 17 significant
/// digits).
std::string FormatDouble(double value);

}  // namespace dn
