#include <algorithm>
#include <cmath>
#include <utility>

#include "sections.h"
#include "swath_map.h"

namespace dn::page_internal {
namespace {

void AddBoresights(const Facts& scanner, const std::string& whose, Table* table) {
  table->rows.push_back(Row("of the new points" + whose, Three(scanner["boresight_deg"], 5)));
  table->rows.push_back(
      Row("of the old points" + whose, Three(scanner["boresight_before_deg"], 5)));
}

Headline GeorefHeadline(const Facts& georef) {
  Headline headline{
      "georeferenced",
      "The point clouds of this folder were computed with this boresight and this trajectory.",
      Tone::kGood};
  Table table = AngleTable("Boresight [deg]");
  if (!georef["scanners"]) AddBoresights(georef, "", &table);
  for (const Facts& scanner : georef["scanners"].elements()) {
    AddBoresights(scanner, ", scanner " + scanner["name"].text(), &table);
  }
  headline.figures = {std::move(table)};
  headline.next = {"dn match FLIGHT --out DIR: the distances between the strips"};
  return headline;
}

Table StripsTable(const Facts& strips) {
  Table table{"",
              {"strip", "points", "kept", "moved, rms [m]", "at most [m]", "laser vectors"},
              {},
              "Points without a pose were dropped. report.json has their number by reason."};
  for (const Facts& strip : strips.elements()) {
    table.rows.push_back(
        Row(strip["scanner"] ? strip["scanner"].text() + "_" + strip["name"].text()
                             : strip["name"].text(),
            {strip["points"].Count(), strip["kept"].Count(), strip["shift_rms_m"].Decimals(3),
             strip["shift_max_m"].Decimals(3), Text(strip["laser_vectors"].text())}));
  }
  return table;
}

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

Section DifferencesSection(const ResultFolder& folder, const Facts& pairs) {
  Section section{"Do the strips agree?", {}};
  if (pairs.elements().empty()) return section;
  section.contents.emplace_back(DifferencesTable(pairs));
  for (MapChart& map :
       DistanceMaps(folder, "Height differences on flat ground", SampledCells(pairs))) {
    section.contents.emplace_back(Chart{std::move(map)});
  }
  return section;
}

}  // namespace

Document GeorefPage(const ResultFolder& folder) {
  const Facts georef = folder.Read("georef.json");
  Document document = Begin(folder, georef["flight"].text(), "georeferenced strips");
  document.headlines = {GeorefHeadline(georef)};
  Section strips{"Strips", {StripsTable(georef["strips"])}};
  MapChart map = SwathMap(folder, "Swaths and paths");
  if (!map.areas.empty()) strips.contents.emplace_back(Chart{std::move(map)});
  Append(std::move(strips), &document);
  Append(DifferencesSection(folder, georef["strip_differences"]), &document);
  return document;
}

}  // namespace dn::page_internal
