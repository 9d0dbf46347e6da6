#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace dn {

/// Returns the candidate nearest to `word` by edit distance; empty without candidates.
std::string NearestName(const std::string& word, const std::vector<std::string>& candidates);

/// Returns whether the name is in the list.
bool HasName(const std::vector<std::string>& names, std::string_view name);

/// Joins names as "a, b, c".
std::string JoinNames(const std::vector<std::string>& names);

/// Returns true if the text contains a control character, such as a line break or an escape,
/// including U+0080 to U+009F in UTF-8.
bool HasControls(std::string_view text);

/// Returns a word as a POSIX shell must read it: unchanged if possible, else in quotes. A word with
/// control characters is written with hexadecimal escapes, as bash, zsh and ksh read them.
std::string QuoteForShell(std::string_view word);

/// Returns the text with a blank in place of every control character, so that it fits on one line
/// of any output.
std::string WithoutControls(std::string_view text);

}  // namespace dn
