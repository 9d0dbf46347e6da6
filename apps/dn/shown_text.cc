#include "shown_text.h"

#include <dn/names.h>
#include <fmt/format.h>

#include <algorithm>

namespace dn::apps {
namespace {

constexpr std::size_t kLongestQuoted = 60;
constexpr std::size_t kLongestWord = 300;
constexpr std::size_t kWordBegin = 200;
constexpr std::size_t kWordEnd = 60;

bool Continues(char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) == 0x80U; }

/// Returns the number of bytes of the UTF-8 character at the start of the text, or 0 if the text
/// does not start with one.
std::size_t CharacterBytes(std::string_view text) {
  const auto first = static_cast<unsigned char>(text[0]);
  const std::size_t bytes = first < 0x80                     ? 1
                            : first >= 0xC2 && first <= 0xDF ? 2
                            : first >= 0xE0 && first <= 0xEF ? 3
                            : first >= 0xF0 && first <= 0xF4 ? 4
                                                             : 0;
  if (bytes == 0 || bytes > text.size()) return 0;
  const std::string_view rest = text.substr(1, bytes - 1);
  return std::all_of(rest.begin(), rest.end(), Continues) ? bytes : 0;
}

std::string Escaped(std::string_view bytes) {
  std::string text;
  for (const char byte : bytes) text += fmt::format("\\x{:02X}", static_cast<unsigned char>(byte));
  return text;
}

/// Returns whether more bytes may complete the character at the start of the text.
bool IsUnfinished(std::string_view text) {
  constexpr std::size_t kLongestCharacter = 4;
  if (text.size() >= kLongestCharacter) return false;
  for (const std::string_view rest : {"\x80", "\x80\x80", "\x80\x80\x80"}) {
    if (CharacterBytes(std::string(text).append(rest)) == text.size() + rest.size()) return true;
  }
  return false;
}

/// Removes the first character from the text and returns it in a form that is safe for a terminal.
std::string TakeCharacter(std::string_view* text) {
  const std::size_t bytes = CharacterBytes(*text);
  const std::string_view character = text->substr(0, std::max<std::size_t>(bytes, 1));
  text->remove_prefix(character.size());
  return bytes == 0 || HasControls(character) ? Escaped(character) : std::string(character);
}

/// Returns at most `bytes` bytes from the start, without cutting a character.
std::string_view Begin(std::string_view text, std::size_t bytes) {
  while (bytes > 0 && bytes < text.size() && Continues(text[bytes])) --bytes;
  return text.substr(0, bytes);
}

std::string_view End(std::string_view text, std::size_t bytes) {
  std::size_t start = text.size() - bytes;
  while (start < text.size() && Continues(text[start])) ++start;
  return text.substr(start);
}

std::string Shortened(std::string_view word) {
  if (word.size() <= kLongestWord) return std::string(word);
  return fmt::format("{}...{}", Begin(word, kWordBegin), End(word, kWordEnd));
}

}  // namespace

std::string Printable(std::string_view text) {
  std::string line, word;
  while (!text.empty()) {
    const std::string character = TakeCharacter(&text);
    if (character == " ") {
      line += Shortened(word) + " ";
      word.clear();
    } else {
      word += character;
    }
  }
  return line + Shortened(word);
}

std::string PrintableStream::Next(std::string_view bytes) {
  const std::string joined = unfinished_ + std::string(bytes);
  std::string_view left = joined;
  std::string shown;
  while (!left.empty() && !IsUnfinished(left)) {
    const bool ends_line = left.front() == '\n';
    shown += ends_line ? "\n" : TakeCharacter(&left);
    if (ends_line) left.remove_prefix(1);
  }
  unfinished_ = left;
  return shown;
}

std::string Quoted(std::string_view word) {
  if (word.size() <= kLongestQuoted) return fmt::format("'{}'", word);
  return fmt::format("'{}...'", Begin(word, kLongestQuoted));
}

}  // namespace dn::apps
