#include <dn/config/yaml_value.h>
#include <dn/files/truth.h>
#include <dn/geo/read_file.h>

namespace dn {

std::optional<Eigen::Vector3d> ReadTrueBoresightDeg(const std::filesystem::path& folder,
                                                    const std::string& scanner) {
  const std::filesystem::path file = folder / "truth.yaml";
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    const YamlValue truth = ParseYaml(ReadWholeFile(file, kMaxYamlBytes), file.string());
    if (scanner.empty()) return ReadVector3(truth["boresight_deg"]);
    for (const YamlValue& one : truth["scanners"].List()) {
      if (one["name"].Text() == scanner) return ReadVector3(one["boresight_deg"]);
    }
    return std::nullopt;
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

}  // namespace dn
