#include <algorithm>
#include <cmath>

#include "sections.h"
#include "swath_map.h"

namespace dn::page_internal {
namespace {

/// Limits of the swath overlap difference, RMSDz [m]: USGS Lidar Base Specification 2.1, table 2.
struct QualityLevel {
  const char* name;
  double most_m;
};
constexpr QualityLevel kUsgs[] = {{"QL0", 0.04}, {"QL1, QL2", 0.08}, {"QL3", 0.16}};

/// Returns a row of the differences of two strips, before or after.
std::vector<Cell> DifferencesRow(const Facts& pair, const std::string& when) {
  const Facts all = pair[when], shares = all["separation"];
  std::vector<Cell> cells{Text(when), all["cells"].Count(), all["median_m"].Decimals(4),
                          all["rms_m"].Decimals(4)};
  for (const char* share : {"to_8_cm", "8_to_16_cm", "above_16_cm"}) {
    cells.push_back(shares[share].Decimals(1, 100.0));
  }
  return Row(pair["strips"][0].text() + "-" + pair["strips"][1].text(), std::move(cells));
}

Table DifferencesTable(const Facts& pairs) {
  Table table{
      "Height differences on flat ground",
      {"strips", "", "cells", "median [m]", "rms [m]", "to 8 cm [%]", "8 to 16 cm", "above 16 cm"},
      {},
      "Second strip minus first, in cells that are flat in both. The last three columns "
      "are the classes of the swath separation images of the USGS Lidar Base "
      "Specification. The folder differences has the rasters."};
  for (const Facts& pair : pairs.elements()) {
    table.rows.push_back(DifferencesRow(pair, "before"));
    table.rows.push_back(DifferencesRow(pair, "after"));
  }
  return table;
}

PlacedDistances SampledCells(const Facts& pairs) {
  PlacedDistances cells;
  for (const Facts& pair : pairs.elements()) {
    const Facts sample = pair["sample"];
    const std::vector<Facts> east = sample["east_m"].elements(),
                             north = sample["north_m"].elements(),
                             before = sample["before_m"].elements(),
                             after = sample["after_m"].elements();
    const std::size_t count = std::min({east.size(), north.size(), before.size(), after.size()});
    for (std::size_t k = 0; k < count; ++k) {
      cells.Add(east[k].number(), north[k].number(), std::abs(before[k].number()),
                std::abs(after[k].number()));
    }
  }
  return cells;
}

/// Returns the rms of all cells, m.
double PooledRms(const Facts& pairs, const char* when) {
  double squares = 0.0, cells = 0.0;
  for (const Facts& pair : pairs.elements()) {
    const double count = pair[when]["cells"].number();
    squares += count * std::pow(pair[when]["rms_m"].number(), 2);
    cells += count;
  }
  return std::sqrt(squares / cells);
}

}  // namespace

Table UsgsTable(double rms_m, const std::string& note) {
  Table table{"Height differences between the swaths, by USGS quality level",
              {"quality level", "at most [m]", "here [m]", ""},
              {},
              "Swath overlap difference (RMSDz) of the USGS Lidar Base Specification 2.1. " + note};
  for (const QualityLevel& level : kUsgs) {
    const bool met = rms_m <= level.most_m;
    table.rows.push_back(
        Row(level.name, {Cell{Number{level.most_m, 2}}, Cell{Number{rms_m, 3}},
                         Text(met ? "met" : "not met", met ? Tone::kGood : Tone::kDoubtful)}));
  }
  return table;
}

Section StripSurfacesSection(const ResultFolder& folder) {
  const Facts pairs = folder.Read("georef.json")["strip_differences"];
  Section section{"Do the strips agree?", {}};
  if (pairs.elements().empty()) return section;
  section.contents.emplace_back(DifferencesTable(pairs));
  section.contents.emplace_back(
      UsgsTable(PooledRms(pairs, "after"), "All cells that are flat in both strips."));
  for (MapChart& map :
       DistanceMaps(folder, "Height differences on flat ground", SampledCells(pairs))) {
    section.contents.emplace_back(Chart{std::move(map)});
  }
  return section;
}

}  // namespace dn::page_internal
