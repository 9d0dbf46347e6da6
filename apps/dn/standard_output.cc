#include "standard_output.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <string_view>

#include "shown_text.h"

namespace dn::apps {
namespace {

bool WriteToStandardOutput(std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, text.data(), text.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

// Write function for fopencookie(3). Returns the number of bytes taken, or 0 for an error.
ssize_t WriteShown(void* stream, const char* bytes, std::size_t count) {
  try {
    const std::string shown = static_cast<PrintableStream*>(stream)->Next({bytes, count});
    return WriteToStandardOutput(shown) ? static_cast<ssize_t>(count) : 0;
  } catch (const std::exception&) {
    return 0;
  }
}

}  // namespace

void GuardStandardOutput() {
  static PrintableStream stream;
  static std::array<char, std::size_t{1} << 20> buffer;
  std::FILE* guarded = ::fopencookie(&stream, "w", {nullptr, &WriteShown, nullptr, nullptr});
  if (guarded != nullptr) stdout = guarded;
  std::setvbuf(stdout, buffer.data(), _IOFBF, buffer.size());
}

}  // namespace dn::apps
