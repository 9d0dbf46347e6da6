#include "input_files.h"

#include <algorithm>
#include <set>

#include "sha256.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

std::string NameInFlight(const fs::path& file, const std::vector<fs::path>& folders) {
  const fs::path whole = fs::absolute(file).lexically_normal();
  for (const fs::path& folder : folders) {
    const fs::path inside =
        whole.lexically_relative((fs::absolute(folder) / "").lexically_normal());
    if (!inside.empty() && *inside.begin() != ".." && inside != ".") return inside.string();
  }
  return file.string();
}

}  // namespace

Json InputFilesJson(const Inputs& inputs) {
  Json list = Json::array();
  std::set<fs::path> seen;
  for (const fs::path& file : inputs.files) {
    std::error_code none;
    const fs::path canonical = fs::canonical(file, none);
    if (none || !fs::is_regular_file(canonical, none) || !seen.insert(canonical).second) continue;
    const auto identity = IdentifyFile(file);
    if (!identity) continue;
    list.push_back({{"file", NameInFlight(file, inputs.folders)},
                    {"bytes", identity->bytes},
                    {"sha256", identity->sha256}});
  }
  return list;
}

}  // namespace dn::apps
