#pragma once

#include <string>
#include <string_view>

namespace dn::apps {

/// The text fit for one line of a terminal: control characters and bytes that are no UTF-8 as \xNN,
/// of words beyond 300 characters, such as overlong paths, only the begin and the end.
std::string Printable(std::string_view text);

/// Makes text that comes in parts fit for a terminal: line breaks stay, other control characters and
/// bytes that are no UTF-8 become \xNN.
class PrintableStream {
 public:
  /// The next part; the first bytes of a character wait for its last.
  std::string Next(std::string_view bytes);

 private:
  std::string unfinished_;
};

/// A word of the command line as a message shows it: in quotes, at most 60 characters of it.
std::string Quoted(std::string_view word);

}  // namespace dn::apps
