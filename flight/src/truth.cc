#include <dn/flight/truth.h>
#include <yaml-cpp/yaml.h>

namespace dn {

std::optional<Eigen::Vector3d> ReadTrueBoresightDeg(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "truth.yaml";
  if (!std::filesystem::exists(file)) return std::nullopt;
  try {
    const YAML::Node angles = YAML::LoadFile(file.string())["boresight_deg"];
    if (!angles || angles.size() != 3) return std::nullopt;
    return Eigen::Vector3d(angles[0].as<double>(), angles[1].as<double>(), angles[2].as<double>());
  } catch (const YAML::Exception&) {
    return std::nullopt;
  }
}

}  // namespace dn
