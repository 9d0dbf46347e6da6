#include "config_sections.h"

namespace dn::files_internal {

namespace {

constexpr std::size_t kMostFiles = 100;
constexpr std::size_t kMostChecks = 1000;

std::vector<std::string> ReadTexts(const YamlValue& list, std::size_t most) {
  std::vector<std::string> texts;
  for (const YamlValue& item : list.Items(most)) texts.push_back(ReadName(item));
  return texts;
}

/// Reads three sigmas, or one for all three.
Eigen::Vector3d ReadSigmas(const YamlValue& value) {
  return value.IsScalar() ? Eigen::Vector3d(Eigen::Vector3d::Constant(ReadPositive(value)))
                          : ReadPositiveVector3(value);
}

/// Reads the radius of a search, in which all returns are kept in memory.
double ReadRadius(const YamlValue& value, double otherwise) {
  constexpr double kMostM = 50.0;
  const double radius_m = ReadPositiveOr(value, otherwise);
  if (radius_m > kMostM) value.Fail("must be at most 50 m");
  return radius_m;
}

}  // namespace

ControlConfig ReadControlSection(const YamlValue& section) {
  section.ExpectMap({"files", "crs", "sigma_enu_m", "laser_sigma_m", "datum_shift_sigma_m",
                     "checks", "search_radius_m", "corner_radius_m"});
  ControlConfig control;
  if (section["files"]) control.files = ReadTexts(section["files"], kMostFiles);
  if (section["crs"]) control.crs = ReadTextCrs(section["crs"]);
  if (section["sigma_enu_m"]) control.sigma_enu_m = ReadSigmas(section["sigma_enu_m"]);
  if (section["laser_sigma_m"]) control.laser_sigma_m = ReadPositive(section["laser_sigma_m"]);
  if (section["datum_shift_sigma_m"]) {
    control.datum_shift_sigma_m = ReadSigmas(section["datum_shift_sigma_m"]);
  }
  if (section["checks"]) control.checks = ReadTexts(section["checks"], kMostChecks);
  control.search_radius_m = ReadRadius(section["search_radius_m"], control.search_radius_m);
  control.corner_radius_m = ReadRadius(section["corner_radius_m"], control.corner_radius_m);
  return control;
}

}  // namespace dn::files_internal
