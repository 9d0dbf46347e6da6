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

}  // namespace

Document GeorefPage(const ResultFolder& folder) {
  const Facts georef = folder.Read("georef.json");
  Document document = Begin(folder, georef["flight"].text(), "georeferenced strips");
  document.headlines = {GeorefHeadline(georef)};
  Section strips{"Strips", {StripsTable(georef["strips"])}};
  MapChart map = SwathMap(folder, "Swaths and paths");
  if (!map.areas.empty()) strips.contents.emplace_back(Chart{std::move(map)});
  Append(std::move(strips), &document);
  Append(StripSurfacesSection(folder), &document);
  return document;
}

}  // namespace dn::page_internal
