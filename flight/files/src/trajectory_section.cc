#include <dn/geo/text_coordinates.h>

#include "config_names.h"
#include "config_sections.h"

namespace dn::files_internal {

ColumnNames ReadColumnNames(const YamlValue& section, const std::vector<std::string>& quantities) {
  constexpr std::size_t kMostColumns = 1000;
  const YamlValue list = section["columns"];
  ColumnNames names;
  if (!list) return names;
  for (const YamlValue& name : list.List(kMostColumns)) names.push_back(name.Text());
  try {
    CheckColumnNames(names, quantities);
  } catch (const InvalidInput& error) {
    list.Fail(error.what());
  }
  return names;
}

std::string ReadTextCrs(const YamlValue& crs) {
  std::string name = ReadName(crs);
  if (!TextCoordinates::IsName(name)) {
    crs.Fail("'" + name +
             "' is not one of geographic, map, utm:ZONEn, utm:ZONEs (as utm:32n), ecef");
  }
  return name;
}

bool ReadNorth(const YamlValue& north, const std::string& crs) {
  const bool grid = north.Choice(NorthWords());
  if (grid && crs.rfind("utm:", 0) != 0) {
    north.Fail("grid needs coordinates in a UTM grid; set crs to utm:ZONEn or utm:ZONEs");
  }
  return grid;
}

namespace {

TrajectoryColumns ReadColumns(const YamlValue& section) {
  TrajectoryColumns columns;
  if (section["crs"]) columns.crs = ReadTextCrs(section["crs"]);
  if (section["attitude"]) columns.attitude = section["attitude"].Choice(AttitudeWords());
  if (section["north"]) columns.grid_north = ReadNorth(section["north"], columns.crs);
  columns.names = ReadColumnNames(section, TrajectoryQuantities(columns.has_quaternion()));
  return columns;
}

}  // namespace

TrajectoryConfig ReadTrajectorySection(const YamlValue& section) {
  section.ExpectMap({"file", "columns", "crs", "attitude", "north", "sigma_xy_m", "sigma_z_m",
                     "sigma_rp_deg", "sigma_y_deg", "sigma_file"});
  TrajectoryConfig trajectory;
  if (section["file"]) trajectory.file = section["file"].Text();
  trajectory.columns = ReadColumns(section);
  if (section["sigma_file"]) trajectory.sigma_file = section["sigma_file"].Text();
  if (section["sigma_xy_m"]) trajectory.sigma_xy_m = ReadPositive(section["sigma_xy_m"]);
  if (section["sigma_z_m"]) trajectory.sigma_z_m = ReadPositive(section["sigma_z_m"]);
  if (section["sigma_rp_deg"]) {
    trajectory.sigma_rp_rad = RadFromDeg(ReadPositive(section["sigma_rp_deg"]));
  }
  if (section["sigma_y_deg"]) {
    trajectory.sigma_y_rad = RadFromDeg(ReadPositive(section["sigma_y_deg"]));
  }
  return trajectory;
}

}  // namespace dn::files_internal
