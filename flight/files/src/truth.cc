#include <dn/config/yaml_value.h>
#include <dn/files/truth.h>
#include <dn/geo/read_file.h>

namespace dn {

std::optional<Eigen::Vector3d> ReadTrueBoresightDeg(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "truth.yaml";
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    return ReadVector3(
        ParseYaml(ReadWholeFile(file, kMaxYamlBytes), file.string())["boresight_deg"]);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

}  // namespace dn
