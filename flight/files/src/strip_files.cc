#include <dn/error.h>
#include <dn/flight/strip_files.h>

#include <algorithm>
#include <cctype>
#include <system_error>

namespace dn {
namespace {

namespace fs = std::filesystem;

bool IsStripName(const fs::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return ending == ".las" || ending == ".laz" || ending == ".txt";
}

std::string NameOf(const StripCrs& said) {
  const std::string code = said.epsg ? "EPSG:" + std::to_string(*said.epsg) : "";
  return code.empty() ? "'" + said.text + "'" : code;
}

}  // namespace

std::vector<fs::path> FindStripFiles(const fs::path& flight_folder) {
  std::vector<fs::path> files;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(flight_folder / "strips", none)) {
    const bool hidden = entry.path().filename().string().starts_with('.');
    if (!hidden && IsStripName(entry.path())) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<fs::path> NeedStripFiles(const fs::path& flight_folder) {
  std::vector<fs::path> files = FindStripFiles(flight_folder);
  if (!files.empty()) return files;
  throw InvalidInput(
      "the flight has no strips; put point clouds (.las, or .txt of t, x, y, z, ux, uy, uz) into " +
      (flight_folder / "strips").string());
}

std::string CheckStripCrs(const StripCrs& said, const std::string& strips_crs,
                          const fs::path& file) {
  const FileLocation where{file.string()};
  if (strips_crs == "none") return {};
  if (!said.name.empty() && said.name != strips_crs) {
    throw InvalidConfig("the points are in " + NameOf(said) +
                            ", but strips_crs of flight.yaml is " + strips_crs +
                            "; write strips_crs: " + said.name,
                        where);
  }
  if (said.name.empty() && said.epsg && strips_crs == "map") {
    throw InvalidConfig(
        "the points are in " + NameOf(said) +
            ", but strips_crs of flight.yaml is map; convert them to UTM or ECEF on "
            "WGS84, and write strips_crs: utm:ZONEn or ecef",
        where);
  }
  if (said.heights_from_geoid) {
    return "by the header of " + file.filename().string() +
           ", its heights refer to a vertical datum; they are used as ellipsoidal heights";
  }
  if (said.name.empty() && said.epsg) {
    return "by the header of " + file.filename().string() + ", its points are in " + NameOf(said) +
           "; they are used as " + strips_crs;
  }
  return {};
}

}  // namespace dn
