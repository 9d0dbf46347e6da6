#include <dn/report/wrapped.h>

#include <cstddef>
#include <sstream>

namespace dn {
namespace {

constexpr std::size_t kLineWidth = 100;

}  // namespace

std::string WrapText(const std::string& text, const std::string& indent) {
  std::istringstream words(text);
  std::string out, line, word;
  while (words >> word) {
    if (!line.empty() && indent.size() + line.size() + 1 + word.size() > kLineWidth) {
      out += line;
      out += "\n";
      out += indent;
      line.clear();
    }
    line += (line.empty() ? "" : " ") + word;
  }
  return out + line + "\n";
}

}  // namespace dn
