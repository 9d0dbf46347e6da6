#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

/// Returns the corrections of the observable beams with a band of one sigma, or their sigmas.
SeriesChart CorrectionChart(const Facts& scanner, const Facts& corrections,
                            const std::string& title) {
  const std::string unit = corrections["unit"].text();
  Curve curve{"correction, one sigma", {}, {}};
  curve.points = true;
  for (std::size_t k = 0; k < scanner["ends"].elements().size(); ++k) {
    if (!corrections["observable"][k].flag()) continue;
    const double value = corrections["value"] ? corrections["value"][k].number() : 0.0;
    const double sigma = corrections["sigma"][k].number();
    curve.x.push_back(static_cast<double>(k));
    curve.y.push_back(value);
    curve.low.push_back(value - sigma);
    curve.high.push_back(value + sigma);
  }
  return {title, "beam", title + " [" + unit + "]", {std::move(curve)}};
}

std::vector<Cell> CorrectionCells(const Facts& corrections, std::size_t beam) {
  if (!corrections) return {Text(""), Text("")};
  const bool observable = corrections["observable"][beam].flag();
  return {observable ? corrections["value"][beam].Significant(4)
                     : Text("not observable", Tone::kDoubtful),
          corrections["sigma"][beam].Significant(2)};
}

Table CorrectionTable(const Facts& scanner) {
  Table table{"Corrections relative to the mean of the beams",
              {"beam", "ends of pairs", "angle [deg]", "sigma [deg]", "range [m]", "sigma [m]"},
              {}};
  table.note =
      "A beam is not observable if the data say less about it than the prior of lidar.beams. The "
      "mean angle of all beams is part of the boresight, the mean range that of a range offset.";
  for (std::size_t k = 0; k < scanner["ends"].elements().size(); ++k) {
    std::vector<Cell> cells{scanner["ends"][k].Count()};
    for (const char* key : {"angle", "range_offset"}) {
      for (Cell& cell : CorrectionCells(scanner[key], k)) cells.push_back(std::move(cell));
    }
    table.rows.push_back(Row(std::to_string(k), std::move(cells)));
  }
  return table;
}

}  // namespace

Section BeamSection(const Facts& result) {
  Section section{"How do the beams differ?", {}};
  for (const Facts& scanner : result["beams"].elements()) {
    const std::string name = scanner["scanner"].text();
    const std::string of_scanner = name.empty() ? "" : " of scanner " + name;
    for (const auto& [key, title] :
         {std::pair("angle", "Beam angle"), {"range_offset", "Beam range offset"}}) {
      if (!scanner[key]) continue;
      section.contents.emplace_back(
          Chart{CorrectionChart(scanner, scanner[key], title + of_scanner)});
    }
    section.contents.emplace_back(CorrectionTable(scanner));
  }
  return section;
}

}  // namespace dn::page_internal
