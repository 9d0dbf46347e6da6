#include <dn/files/atomic_file.h>
#include <dn/geo/file_writer.h>

namespace dn {

void WriteFileAtomically(const std::filesystem::path& path, std::string_view content) {
  FileWriter file(path);
  file.Append(content);
  file.Publish();
}

}  // namespace dn
