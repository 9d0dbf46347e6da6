#include <dn/names.h>

#include <algorithm>
#include <numeric>

namespace dn {
namespace {

std::size_t EditDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row.back();
}

/// Returns the number of bytes of the control character at the start of the text, or 0 if it starts
/// with another character.
std::size_t ControlBytes(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  if (first < 0x20 || first == 0x7F) return 1;
  const bool beyond_ascii = first == 0xC2 && text.size() > 1 &&
                            static_cast<unsigned char>(text[1]) >= 0x80 &&
                            static_cast<unsigned char>(text[1]) < 0xA0;
  return beyond_ascii ? 2 : 0;
}

bool IsPlainInShell(char c) {
  constexpr std::string_view kPlain = "_-./=:@%+,";
  return (c >= '0' && c <= '9') || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
         kPlain.find(c) != std::string_view::npos;
}

}  // namespace

std::string NearestName(const std::string& word, const std::vector<std::string>& candidates) {
  const auto nearest = std::min_element(candidates.begin(), candidates.end(),
                                        [&](const std::string& a, const std::string& b) {
                                          return EditDistance(word, a) < EditDistance(word, b);
                                        });
  return nearest == candidates.end() ? std::string() : *nearest;
}

bool HasName(const std::vector<std::string>& names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

std::string JoinNames(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

bool HasControls(std::string_view text) {
  for (; !text.empty(); text.remove_prefix(1)) {
    if (ControlBytes(text) > 0) return true;
  }
  return false;
}

std::string WithoutControls(std::string_view text) {
  std::string plain;
  while (!text.empty()) {
    const std::size_t control = ControlBytes(text);
    plain += control > 0 ? ' ' : text[0];
    text.remove_prefix(control > 0 ? control : 1);
  }
  return plain;
}

std::string QuoteForShell(std::string_view word) {
  if (!word.empty() && std::all_of(word.begin(), word.end(), IsPlainInShell)) {
    return std::string(word);
  }
  const bool controls = HasControls(word);
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string quoted = controls ? "$'" : "'";
  for (const char c : word) {
    const auto byte = static_cast<unsigned char>(c);
    if (controls && (byte < 0x20 || byte >= 0x7F || c == '\'' || c == '\\')) {
      quoted.append("\\x").append(1, kDigits[byte >> 4]).append(1, kDigits[byte & 15U]);
    } else if (c == '\'') {
      quoted += "'\\''";
    } else {
      quoted += c;
    }
  }
  return quoted + "'";
}

}  // namespace dn
