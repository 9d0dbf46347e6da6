#include "crs_names.h"

#include <dn/error.h>
#include <dn/geo/point_crs.h>

#include <array>
#include <cmath>
#include <regex>

#include "projected_crs.h"

namespace dn {
namespace geo_internal {
namespace {

struct HeightUnit {
  const char* ending;
  double m;
};
constexpr std::array<HeightUnit, 2> kHeightUnits{
    {{" heights:ft", kFootM}, {" heights:us-ft", kUsSurveyFootM}}};

/// Returns the ending of a name for a unit; nullopt for an unknown unit.
std::optional<std::string> UnitEnding(double unit_m) {
  if (std::abs(unit_m - 1.0) < 1e-9) return "";
  for (const HeightUnit& unit : kHeightUnits) {
    if (std::abs(unit_m - unit.m) < 1e-9) return unit.ending;
  }
  return std::nullopt;
}

std::string UtmName(int zone, bool south) {
  return "utm:" + std::to_string(zone) + (south ? "s" : "n");
}

/// Returns the short name of a system on WGS84, ETRS89 or NAD83 (which differ by less than 3 m);
/// empty for other systems.
std::string ShortName(int epsg) {
  const int zone = epsg % 100;
  const auto utm = [&](int first, int from, int to) {
    return epsg - zone == first && zone >= from && zone <= to;
  };
  if (epsg == 4978 || epsg == 4936) return "ecef";
  // These have the northing first. In point clouds, x is the easting all the same.
  if (epsg >= 3038 && epsg <= 3051) return UtmName(epsg - 3012, false);
  if (utm(32600, 1, 60)) return UtmName(zone, false);
  if (utm(32700, 1, 60)) return UtmName(zone, true);
  if (utm(25800, 28, 38) || utm(26900, 1, 23)) return UtmName(zone, false);
  return {};
}

bool IsCode(const std::string& text) {
  static const std::regex pattern("[1-9][0-9]{3,5}([+][1-9][0-9]{3,5})?");
  return std::regex_match(text, pattern);
}

/// Returns the name of the horizontal part.
std::string HorizontalName(const StatedSystem& system) {
  if (system.geocentric) return "ecef";
  if (system.horizontal) return ShortCrsName("epsg:" + *system.horizontal);
  return "wkt:" + system.horizontal_text;
}

/// Returns why PROJ has no transformation; empty if it has one.
std::string WhyNot(const std::string& definition) {
  try {
    const ProjectedCrs possible(definition);
    return {};
  } catch (const InvalidConfig& e) {
    return e.what();
  }
}

/// Replaces the name of a compound system by one with its heights, if PROJ can transform these.
void TakeHeights(const std::string& definition, const StatedSystem& system, NamedCrs* named) {
  const bool coded = system.horizontal && system.vertical;
  const std::string codes = coded ? *system.horizontal + "+" + *system.vertical : "";
  named->why_not = WhyNot(coded ? "EPSG:" + codes : definition);
  named->heights_from_geoid = !named->why_not.empty();
  if (!named->heights_from_geoid) named->name = coded ? "epsg:" + codes : "wkt:" + definition;
}

}  // namespace

CrsName SplitCrsName(const std::string& name) {
  for (const HeightUnit& unit : kHeightUnits) {
    if (name.ends_with(unit.ending)) {
      return {name.substr(0, name.size() - std::string(unit.ending).size()), unit.m};
    }
  }
  return {name, 1.0};
}

std::optional<UtmZone> ParseUtm(const std::string& system) {
  static const std::regex pattern("utm:([1-9]|[1-5][0-9]|60)([ns])");
  std::smatch match;
  if (!std::regex_match(system, match, pattern)) return std::nullopt;
  return UtmZone{std::stoi(match[1]), match[2] == "s"};
}

std::optional<std::string> ProjDefinition(const std::string& system) {
  if (system.starts_with("wkt:") && system.size() > 4) return system.substr(4);
  if (system.starts_with("epsg:") && IsCode(system.substr(5))) return "EPSG:" + system.substr(5);
  return std::nullopt;
}

}  // namespace geo_internal

using geo_internal::CrsName;
using geo_internal::SplitCrsName;

bool IsPointCrsName(const std::string& name) {
  if (name == "map" || name == "ecef" || name == "none") return true;
  const std::string system = SplitCrsName(name).system;
  return geo_internal::ParseUtm(system) || geo_internal::ProjDefinition(system);
}

std::string ShortCrsName(const std::string& name) {
  const CrsName parts = SplitCrsName(name);
  const bool one_code = parts.system.starts_with("epsg:") &&
                        geo_internal::IsCode(parts.system.substr(5)) &&
                        parts.system.find('+') == std::string::npos;
  if (!one_code) return name;
  const std::string known = geo_internal::ShortName(std::stoi(parts.system.substr(5)));
  return known.empty() ? name : known + name.substr(parts.system.size());
}

std::string ShownCrsName(const std::string& name) {
  if (!name.starts_with("wkt:")) return name;
  const CrsName parts = SplitCrsName(name);
  const std::size_t begin = parts.system.find('"');
  if (begin == std::string::npos) return name;
  const std::size_t end = parts.system.find('"', begin + 1);
  return parts.system.substr(begin, end == std::string::npos ? end : end + 1 - begin) +
         name.substr(parts.system.size());
}

std::optional<std::string> PrjText(const std::string& name) {
  const std::string system = SplitCrsName(name).system;
  if (const auto utm = geo_internal::ParseUtm(system)) {
    const int first = utm->south ? 32700 : 32600;
    return geo_internal::HorizontalEsriText("EPSG:" + std::to_string(first + utm->zone));
  }
  const auto definition = geo_internal::ProjDefinition(system);
  return definition ? geo_internal::HorizontalEsriText(*definition) : std::nullopt;
}

bool IsSameCrs(const std::string& a, const std::string& b) {
  if (ShortCrsName(a) == ShortCrsName(b)) return true;
  const CrsName one = SplitCrsName(a), other = SplitCrsName(b);
  if (one.height_unit_m != other.height_unit_m) return false;
  const auto first = geo_internal::ProjDefinition(one.system),
             second = geo_internal::ProjDefinition(other.system);
  return first && second && geo_internal::AreSameSystem(*first, *second);
}

NamedCrs NameCrs(const std::string& definition, std::optional<double> height_unit_m) {
  NamedCrs named;
  const auto system = geo_internal::ReadSystem(definition);
  if (!system) return named;
  if (system->horizontal) named.epsg = std::stoi(*system->horizontal);
  const double unit_m = height_unit_m.value_or(system->height_unit_m);
  named.in_metres = unit_m == 1.0 && system->horizontal_unit_m == 1.0;
  if (system->compound && unit_m == system->height_unit_m) {
    geo_internal::TakeHeights(definition, *system, &named);
    if (!named.name.empty()) return named;
  }
  named.heights_from_geoid = system->compound;
  const auto ending = geo_internal::UnitEnding(unit_m);
  if (ending) named.name = geo_internal::HorizontalName(*system) + *ending;
  return named;
}

std::optional<double> CrsUnitM(const std::string& definition) {
  const auto system = geo_internal::ReadSystem(definition);
  if (!system) return std::nullopt;
  return system->horizontal_unit_m;
}

Eigen::Vector3d CrsUnitsM(const std::string& name) {
  const CrsName parts = SplitCrsName(name);
  const auto definition = geo_internal::ProjDefinition(parts.system);
  const double horizontal_m = definition ? CrsUnitM(*definition).value_or(1.0) : 1.0;
  return {horizontal_m, horizontal_m, parts.height_unit_m};
}

}  // namespace dn
