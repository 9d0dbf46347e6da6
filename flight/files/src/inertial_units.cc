#include "inertial_units.h"

#include <dn/geo/local_frame.h>
#include <dn/geo/point_crs.h>

#include <algorithm>
#include <array>
#include <numbers>
#include <string_view>

namespace dn::files_internal {
namespace {

struct UnitSize {
  std::string_view unit;
  double size;
};

constexpr double kSecondsPerHour = 3600.0;

// Without the signs of powers and divisions: "deg/s" and "deg s^-1" are "degs" and "degs1".
constexpr std::array<UnitSize, 20> kRateUnits{{{"rads", 1.0},
                                               {"rads1", 1.0},
                                               {"radps", 1.0},
                                               {"rad", 1.0},
                                               {"mrads", 1e-3},
                                               {"mrads1", 1e-3},
                                               {"mradps", 1e-3},
                                               {"mrad", 1e-3},
                                               {"degs", kRadPerDeg},
                                               {"degs1", kRadPerDeg},
                                               {"degps", kRadPerDeg},
                                               {"deg", kRadPerDeg},
                                               {"dps", kRadPerDeg},
                                               {"mdegs", 1e-3 * kRadPerDeg},
                                               {"mdegs1", 1e-3 * kRadPerDeg},
                                               {"mdps", 1e-3 * kRadPerDeg},
                                               {"degh", kRadPerDeg / kSecondsPerHour},
                                               {"degh1", kRadPerDeg / kSecondsPerHour},
                                               {"dph", kRadPerDeg / kSecondsPerHour},
                                               {"rpm", 2.0 * std::numbers::pi / 60.0}}};
constexpr std::array<UnitSize, 14> kForceUnits{{{"ms2", 1.0},
                                                {"mps2", 1.0},
                                                {"mss", 1.0},
                                                {"ms", 1.0},
                                                {"mps", 1.0},
                                                {"ms1", 1.0},
                                                {"g", kStandardGravityMps2},
                                                {"mg", 1e-3 * kStandardGravityMps2},
                                                {"ug", 1e-6 * kStandardGravityMps2},
                                                {"mms2", 1e-3},
                                                {"cms2", 1e-2},
                                                {"gal", 1e-2},
                                                {"fts2", kFootM},
                                                {"ftsec2", kFootM}}};

/// Shortens the words of a unit and leaves out the signs.
std::string ShortUnit(std::string unit) {
  struct Word {
    std::string_view text, brief;
  };
  constexpr std::array<Word, 10> kWords{{{"degrees", "deg"},
                                         {"degree", "deg"},
                                         {"radians", "rad"},
                                         {"radian", "rad"},
                                         {"seconds", "s"},
                                         {"second", "s"},
                                         {"sec", "s"},
                                         {"hour", "h"},
                                         {"milli", "m"},
                                         {"per", "/"}}};
  for (const Word& word : kWords) {
    for (std::size_t at = 0; (at = unit.find(word.text)) != unit.npos;) {
      unit.replace(at, word.text.size(), word.brief);
    }
  }
  std::erase_if(
      unit, [](char c) { return std::string_view("^.*/_- ").find(c) != std::string_view::npos; });
  return unit;
}

template <std::size_t kCount>
std::optional<double> FindSize(const std::array<UnitSize, kCount>& units, const std::string& unit) {
  const std::string brief = ShortUnit(unit);
  for (const UnitSize& each : units) {
    if (each.unit == brief) return each.size;
  }
  return std::nullopt;
}

bool Has(const std::string& unit, std::string_view text) { return unit.find(text) != unit.npos; }

}  // namespace

std::optional<double> RateUnitSize(const std::string& unit) { return FindSize(kRateUnits, unit); }

std::optional<double> ForceUnitSize(const std::string& unit) { return FindSize(kForceUnits, unit); }

bool StatesRateUnit(const std::string& unit) {
  return RateUnitSize(unit) || Has(unit, "rad") || Has(unit, "deg") || Has(unit, "/s") ||
         Has(unit, "/h") || Has(unit, "rev") || Has(unit, "arcsec");
}

bool StatesForceUnit(const std::string& unit) {
  return ForceUnitSize(unit) || Has(unit, "/s") || Has(unit, "s^-2") || Has(unit, "s-2");
}

}  // namespace dn::files_internal
