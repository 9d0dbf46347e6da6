#include <dn/report/document.h>
#include <dn/report/wrapped.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

std::string CellText(const Cell& cell) {
  const auto* number = std::get_if<Number>(&cell.content);
  return number != nullptr ? ToText(*number) : std::get<std::string>(cell.content);
}

/// Returns the number of characters, not bytes, of a UTF-8 text.
std::size_t DisplayWidth(const std::string& text) {
  return static_cast<std::size_t>(std::count_if(text.begin(), text.end(), [](char c) {
    return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U;
  }));
}

std::string PadToWidth(const std::string& text, std::size_t width, bool left) {
  const std::string blanks(width - std::min(width, DisplayWidth(text)), ' ');
  return left ? text + blanks : blanks + text;
}

std::string TableText(const Table& table) {
  std::vector<std::vector<std::string>> lines{table.columns};
  for (const auto& row : table.rows) {
    lines.emplace_back();
    for (const Cell& cell : row) lines.back().push_back(CellText(cell));
  }
  std::vector<std::size_t> widths(table.columns.size(), 0);
  for (const auto& line : lines) {
    for (std::size_t k = 0; k < line.size(); ++k) {
      widths[k] = std::max(widths[k], DisplayWidth(line[k]));
    }
  }
  std::string text = table.title.empty() ? "" : table.title + "\n";
  for (const auto& line : lines) {
    std::string out;
    for (std::size_t k = 0; k < line.size(); ++k)
      out += "  " + PadToWidth(line[k], widths[k], k == 0);
    text += out.substr(0, out.find_last_not_of(' ') + 1) + "\n";
  }
  return text + (table.note.empty() ? "" : "  " + WrapText(table.note, "  "));
}

}  // namespace

std::string ToText(const Number& number) {
  const double shown = number.scale * number.value;
  if (!std::isfinite(shown)) return "–";
  const std::string text = number.style == Number::Style::kDecimals
                               ? fmt::format("{:.{}f}", shown, number.digits)
                               : fmt::format("{:.{}g}", shown, number.digits);
  const bool zero = text.find_first_of("123456789") == std::string::npos;
  return zero && text.front() == '-' ? text.substr(1) : text;
}

std::string ToText(const Document& document) {
  std::string text = document.title + "\n";
  for (const Headline& headline : document.headlines) {
    text += WrapText(headline.word + ": " + headline.answer, "  ");
    for (const std::string& reason : headline.reasons) text += "  " + WrapText(reason, "    ");
    for (const Table& table : headline.figures) text += TableText(table);
  }
  for (const Section& section : document.sections) {
    for (const Content& content : section.contents) {
      if (const auto* table = std::get_if<Table>(&content)) text += TableText(*table);
    }
  }
  return text;
}

}  // namespace dn
