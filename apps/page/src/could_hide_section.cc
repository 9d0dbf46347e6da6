#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sections.h"

namespace dn::page_internal {
namespace {

/// Returns the detectable size of each component alone; "any" if it is undetectable at any size.
std::string DetectableSizes(const Facts& effect) {
  std::vector<std::string> each;
  for (const Facts& size : effect["detectable_by_component"].elements()) {
    each.push_back(size ? fmt::format("{:.2g}", size.number()) : "any");
  }
  return each.size() < 2 ? "" : fmt::format("{}", fmt::join(each, ", "));
}

}  // namespace

Section UndetectableSection(const Facts& effects) {
  Section section{"Undetectable effects", {}};
  Table table{
      "",
      {"effect", "detectable from", "components alone", "identifiable from", "unit",
       "shift roll [mdeg]", "pitch", "yaw"},
      {},
      "An effect below its detectable size may be present, and shift the boresight by up to "
      "the stated angles. The size applies to the best-determined direction; a single component "
      "may need to be larger to be detected."};
  for (const Facts& effect : effects.elements()) {
    std::vector<Cell> row{
        Text(effect["effect"].text()), effect["minimal_detectable"].Significant(2),
        Text(DetectableSizes(effect)), effect["minimal_identifiable"].Significant(2),
        Text(effect["unit"].text())};
    for (const Cell& cell : Three(effect["boresight_damage_mdeg"], 2)) row.push_back(cell);
    table.rows.push_back(std::move(row));
  }
  if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  return section;
}

}  // namespace dn::page_internal
