#include <dn/error.h>

namespace dn {

std::string FileLocation::ToString() const {
  std::string text = file;
  if (!file.empty() && line > 0) {
    text.append(":").append(std::to_string(line));
    if (column > 0) text.append(":").append(std::to_string(column));
  }
  return text;
}

}  // namespace dn
