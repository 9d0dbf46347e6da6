#pragma once

#include <string>
#include <string_view>

namespace dn::apps {

/// Makes a text safe for one line of a terminal: control characters and bytes that are not UTF-8
/// become \xNN. Words above 300 characters, such as overlong paths, keep only start and end.
std::string Printable(std::string_view text);

/// Makes text that arrives in parts safe for a terminal. Line breaks stay; other control characters
/// and bytes that are not UTF-8 become \xNN.
class PrintableStream {
 public:
  /// Returns the next part. The first bytes of an incomplete character are kept for the next call.
  std::string Next(std::string_view bytes);

 private:
  std::string unfinished_;
};

/// Quotes a word of the command line for a message, cut to at most 60 characters.
std::string Quoted(std::string_view word);

}  // namespace dn::apps
