#include <dn/geo/text_table.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <system_error>
#include <utility>

#include "time_continuation.h"

namespace dn {
namespace {

bool IsBlank(char c) { return c == ' ' || c == '\t' || c == '\r'; }

/// Returns a quoted text for messages, shortened and with unprintable characters replaced.
std::string Quoted(std::string_view text) {
  constexpr std::size_t kMaxShown = 40;
  std::string quoted = "'";
  for (const char c : text.substr(0, kMaxShown)) {
    const bool printable = c >= ' ' && c <= '~';
    quoted += printable ? c : '?';
  }
  return quoted + (text.size() > kMaxShown ? "...'" : "'");
}

/// Returns whether a text is one of the words that programs print for infinity and not-a-number.
/// Examples are "NaN", "-1.#IND", "1.#QNAN00", "nan(ind)", "inf", "N/A" and "null".
bool IsNotFiniteWord(std::string_view text) {
  std::string word;
  for (const char c : text) word += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  if (word.starts_with('+') || word.starts_with('-')) word.erase(0, 1);
  if (word.starts_with("1.#")) return true;
  for (const char* name : {"nan", "qnan", "snan", "inf", "#n/a", "n/a", "#nan", "null"}) {
    if (word.starts_with(name)) return true;
  }
  return word == "na" || word == "none";
}

/// Parses a finite number in plain notation, without the extensions that ParseNumber accepts.
std::optional<double> PlainNumber(std::string_view text) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  const bool whole = error == std::errc() && end == text.data() + text.size();
  return whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

std::string NumberList(const std::vector<std::size_t>& numbers) {
  std::string list;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) list += i + 1 == numbers.size() ? " or " : ", ";
    list += std::to_string(numbers[i]);
  }
  return list;
}

/// Parses lines of text and appends them as rows to a table.
class RowParser {
 public:
  RowParser(TextTable& table, const std::vector<std::size_t>& allowed_columns, char comment)
      : table_(table), allowed_columns_(allowed_columns), comment_(comment) {}

  void ParseLine(std::string_view text, long line) {
    line_ = line;
    text_ = text.substr(0, CommentBegin(text));
    position_ = 0;
    SkipBlanks();
    if (AtEnd()) return;
    const std::size_t count_before = table_.values.size();
    ParseValues();
    CheckColumns(table_.values.size() - count_before);
    table_.lines.push_back(line_);
  }

 private:
  // A comment begins where a value could begin. The '#' in "1.#QNAN" belongs to the value.
  std::size_t CommentBegin(std::string_view text) const {
    for (std::size_t i = 0; i < text.size(); ++i) {
      if (text[i] != '#' && text[i] != comment_) continue;
      if (i == 0 || text[i - 1] == ',' || IsBlank(text[i - 1])) return i;
    }
    return text.size();
  }

  bool AtEnd() const { return position_ == text_.size(); }
  void SkipBlanks() {
    while (!AtEnd() && IsBlank(text_[position_])) ++position_;
  }

  FileLocation Here() const {
    return {table_.file.string(), line_, static_cast<long>(position_) + 1};
  }

  // Starts at the first value and stops after the last.
  void ParseValues() {
    bool tight_commas = false, bare_blanks = false;
    while (true) {
      std::size_t end = position_;
      while (end < text_.size() && text_[end] != ',' && !IsBlank(text_[end])) ++end;
      table_.values.push_back(Number(text_.substr(position_, end - position_)));
      position_ = end;
      SkipBlanks();
      if (AtEnd()) break;
      if (text_[position_] != ',') {
        bare_blanks = true;
        continue;
      }
      ++position_;
      const std::size_t after_comma = position_;
      SkipBlanks();
      tight_commas = tight_commas || (position_ == after_comma && end + 1 == after_comma);
    }
    if (tight_commas && bare_blanks) CheckDecimalPoints();
  }

  // Builds the location for a message only if the text is not a plain number.
  double Number(std::string_view text) const {
    const std::optional<double> value = PlainNumber(text);
    return value ? *value : ParseNumber(text, Here());
  }

  // Throws InvalidInput if the row has no decimal point. Such a row has decimal commas: its values
  // are separated by blanks, and no blank follows its commas.
  void CheckDecimalPoints() const {
    if (text_.find('.') != std::string_view::npos) return;
    throw InvalidInput("the row has decimal commas; write decimal points",
                       {table_.file.string(), line_, 0});
  }

  void CheckColumns(std::size_t columns) {
    const FileLocation where{table_.file.string(), line_, 0};
    if (table_.columns == 0) {
      const bool allowed = allowed_columns_.empty() ||
                           std::find(allowed_columns_.begin(), allowed_columns_.end(), columns) !=
                               allowed_columns_.end();
      if (!allowed) {
        throw InvalidInput("row has " + std::to_string(columns) + " columns, must have " +
                               NumberList(allowed_columns_),
                           where);
      }
      table_.columns = columns;
    } else if (columns != table_.columns) {
      throw InvalidInput("row has " + std::to_string(columns) +
                             " columns, but the rows before it have " +
                             std::to_string(table_.columns),
                         where);
    }
  }

  TextTable& table_;
  const std::vector<std::size_t>& allowed_columns_;
  char comment_;
  long line_ = 0;
  std::string_view text_;
  std::size_t position_ = 0;
};

}  // namespace

double ParseNumber(std::string_view text, const FileLocation& where) {
  if (text.empty()) {
    throw InvalidInput("a value is missing (nothing between separators)", where);
  }
  const bool plus = text.size() > 1 && text[0] == '+' && text[1] != '-';
  const char* const begin = text.data() + (plus ? 1 : 0);
  const char* const end = text.data() + text.size();
  double value = 0.0;
  const auto [parsed_end, error] = std::from_chars(begin, end, value);
  if (text.find(';') != std::string_view::npos) {
    throw InvalidInput(Quoted(text) +
                           ": values are separated by commas, blanks or tabs, not by semicolons; "
                           "replace them, and decimal commas by points first",
                       where);
  }
  if (IsNotFiniteWord(text)) throw InvalidInput(Quoted(text) + " is not a finite number", where);
  if (parsed_end != end || error == std::errc::invalid_argument) {
    throw InvalidInput(Quoted(text) + " is not a number; start comments and headers with #", where);
  }
  if (error == std::errc::result_out_of_range) {
    throw InvalidInput(Quoted(text) + " is out of the range of a double", where);
  }
  if (!std::isfinite(value)) {
    throw InvalidInput(Quoted(text) + " is not a finite number", where);
  }
  return value;
}

TextTableReader::TextTableReader(const std::filesystem::path& file,
                                 std::vector<std::size_t> allowed_columns, char comment)
    : lines_(file), allowed_columns_(std::move(allowed_columns)), comment_(comment) {
  table_.file = file;
}

bool TextTableReader::Next(std::size_t max_rows) {
  table_.values.clear();
  table_.lines.clear();
  RowParser parser(table_, allowed_columns_, comment_);
  for (std::string_view line; table_.rows() < max_rows && lines_.Next(&line);) {
    parser.ParseLine(line, lines_.line());
  }
  if (table_.columns == 0) {
    throw InvalidInput("file has no rows of numbers", {table_.file.string(), 0, 0});
  }
  return table_.rows() > 0;
}

TextTable ReadTextTable(const std::filesystem::path& file,
                        const std::vector<std::size_t>& allowed_columns, char comment,
                        std::size_t max_rows) {
  TextTableReader reader(file, allowed_columns, comment);
  reader.Next(max_rows);
  return std::move(reader).table();
}

long ContinueAndCheckTimes(TextTable& table, std::vector<std::size_t>& keep, double time_offset_s) {
  using Verdict = geo_internal::TimeContinuation::Verdict;
  geo_internal::TimeContinuation times;
  long dropped = 0;
  keep.clear();
  keep.reserve(table.rows());
  for (std::size_t i = 0; i < table.rows(); ++i) {
    double* row = table.values.data() + i * table.columns;
    row[0] -= time_offset_s;
    if (!IsWeekSeconds(row[0])) CheckWeekSeconds(row[0], {table.file.string(), table.lines[i], 1});
    switch (times.Next(row, table.columns)) {
      case Verdict::kKeep:
        keep.push_back(i);
        break;
      case Verdict::kRepeatedRow:
        ++dropped;
        break;
      case Verdict::kNotIncreasing:
        throw InvalidInput("time " + FormatDouble(row[0]) +
                               " s does not increase: the row before has " +
                               FormatDouble(times.last_s() - times.offset_s()) +
                               " s; rows must be in the order of time",
                           {table.file.string(), table.lines[i], 1});
    }
  }
  return dropped;
}

std::string FormatDouble(double value) {
  char buffer[32];
  return {buffer, std::to_chars(buffer, buffer + sizeof buffer, value).ptr};
}

}  // namespace dn
