#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

void AddAngles(const std::string& name, const Facts& boresight, Table* table) {
  table->rows.push_back(Row(name, Three(boresight["angles_deg"], 5)));
  table->rows.push_back(Row("sigma", Three(boresight["sigma_deg"], 5)));
}

Table Boresights(const Facts& result) {
  Table table = AngleTable("Boresight of each scanner [deg]");
  for (const Facts& scanner : result["scanners"].elements()) {
    const std::string verdict = scanner["assessment"]["verdict"].text();
    AddAngles(scanner["name"].text() + " (" + verdict + ")", scanner["boresight"], &table);
  }
  return table;
}

std::string TwoNames(const Facts& relative) {
  return relative["scanners"][0].text() + " to " + relative["scanners"][1].text();
}

Table RelativeBoresights(const Facts& result) {
  Table table = AngleTable("Relative boresight of every two scanners [deg]");
  table.note =
      "Errors of the trajectory that both scanners share cancel, so that the sigmas are smaller "
      "than those of either boresight.";
  for (const Facts& relative : result["relative_boresight"].elements()) {
    AddAngles(TwoNames(relative), relative, &table);
  }
  return table;
}

Table RelativeLeverArms(const Facts& result) {
  Table table{"Relative lever arm of every two scanners [m]", {"", "x", "y", "z"}, {}};
  for (const Facts& relative : result["relative_boresight"].elements()) {
    const Facts arm = relative["lever_arm"];
    if (!arm) continue;
    table.rows.push_back(Row(TwoNames(relative), Three(arm["value_m"], 3)));
    table.rows.push_back(Row("sigma", Three(arm["sigma_m"], 3)));
  }
  return table;
}

}  // namespace

Section ScannerSection(const Facts& result) {
  Section section{"How are the scanners mounted?", {}};
  for (Table table : {Boresights(result), RelativeBoresights(result), RelativeLeverArms(result)}) {
    if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  }
  return section;
}

}  // namespace dn::page_internal
