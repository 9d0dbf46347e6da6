#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

Table EmptyTable(std::string title) {
  return {std::move(title),
          {"strips", "", "to 8 cm [%]", "8 to 16 cm", "above 16 cm", "within 3 cm [%]",
           "within 5 cm", "within 10 cm"},
          {}};
}

void AddRow(const Separation& of, Table* table) {
  std::vector<Cell> cells{Text(of.when)};
  for (const char* key :
       {"to_8_cm", "8_to_16_cm", "above_16_cm", "within_3_cm", "within_5_cm", "within_10_cm"}) {
    cells.push_back(of.shares[key].Decimals(1, 100.0));
  }
  table->rows.push_back(Row(of.strips, std::move(cells)));
}

}  // namespace

Section SeparationSection(const std::vector<Separation>& separations) {
  Section section{"Swath separation", {}};
  Table table = EmptyTable("Shares of the pairs by their height difference");
  for (const Separation& of : separations) {
    if (of.shares) AddRow(of, &table);
  }
  if (table.rows.empty()) return section;
  table.note =
      "To 8, 8 to 16 and above 16 cm: classes of the swath separation images of the USGS Lidar "
      "Base Specification, for open ground with slopes below 10 degrees. 3, 5 and 10 cm: levels "
      "of Leica HxMap for its comparison of strips (green, yellow, red), for distances to a "
      "plane. This table has the height differences of all pairs, without regard to slope and "
      "plants. Surfaces are therefore closer than this.";
  section.contents.emplace_back(std::move(table));
  return section;
}

}  // namespace dn::page_internal
