#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace dn {

/// The candidate nearest to `word` by edit distance; empty when there are no candidates.
std::string NearestName(const std::string& word, const std::vector<std::string>& candidates);

/// "a, b, c".
std::string JoinNames(const std::vector<std::string>& names);

/// True where the text holds a control character, such as a line break or an escape, also one of
/// those beyond ASCII (U+0080 to U+009F in UTF-8).
bool HasControls(std::string_view text);

/// A word as a POSIX shell has to read it: as it is, else in quotes. One with control characters is
/// spelt as bash, zsh and ksh read it, $'\xNN'.
std::string QuoteForShell(std::string_view word);

/// The text with a blank in place of every control character: fit for one line of any output.
std::string WithoutControls(std::string_view text);

}  // namespace dn
