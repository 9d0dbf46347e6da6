#include <array>
#include <cstddef>

#include "sections.h"

namespace dn::page_internal {
namespace {

// Limits of good trajectories in LP360's trajectory report, m; larger values are marked.
constexpr std::array<double, 3> kUsualSeparationM{0.02, 0.02, 0.05};

/// Returns the cells of rms values; values above the limits are marked.
std::vector<Cell> Judged(const Facts& rms_enu_m) {
  std::vector<Cell> cells = Three(rms_enu_m, 4);
  for (std::size_t axis = 0; axis < cells.size(); ++axis) {
    if (rms_enu_m[axis].number() > kUsualSeparationM[axis]) cells[axis].tone = Tone::kDoubtful;
  }
  return cells;
}

Table FilterSeparationTable(const Facts& separation) {
  Table table{
      "Forward filter minus reverse filter, after alignment",
      {"", "", "", ""},
      {},
      "Each filter uses only one half of the data at a time; the smoothed trajectory is "
      "better than either. Marked: above 2 cm east or north, or 5 cm up, the limits of good "
      "trajectories in LP360's report."};
  table.rows = {Row("rms, east, north, up [m]", Judged(separation["rms_enu_m"])),
                Row("largest, east, north, up [m]", Three(separation["max_enu_m"], 4)),
                Row("rms, roll, pitch, heading [deg]", Three(separation["rms_rph_deg"], 4)),
                Row("largest, roll, pitch, heading [deg]", Three(separation["max_rph_deg"], 4))};
  return table;
}

Table AccuracyTable(const Facts& accuracy, bool consistent) {
  Table table{"Accuracy: sigmas of the adjustment over the nodes", {"", "", "", ""}, {}};
  if (!consistent)
    table.note = "These sigmas are those of the assumed model, which the data contradict.";
  table.rows = {Row("median, east, north, up [m]", Three(accuracy["median_enu_m"], 4)),
                Row("largest, east, north, up [m]", Three(accuracy["largest_enu_m"], 4)),
                Row("median, roll, pitch, heading [deg]", Three(accuracy["median_rph_deg"], 4)),
                Row("largest, roll, pitch, heading [deg]", Three(accuracy["largest_rph_deg"], 4))};
  return table;
}

Headline SmoothHeadline(const Facts& smooth) {
  const Facts assessment = smooth["assessment"];
  Headline headline;
  headline.word = assessment["verdict"].text();
  headline.reasons = FirstReasons(assessment);
  const bool consistent = headline.word == "consistent";
  headline.tone = consistent ? Tone::kGood : Tone::kBad;
  headline.answer =
      consistent
          ? "You may rely on this trajectory within its sigmas: the data agree with the model."
          : "Do not rely on this trajectory: the data contradict the assumed model.";
  const Facts adjustment = smooth["adjustment"];
  Table figures{"", {"", ""}, {}};
  figures.rows = {Row("sigma0 (1: as stated)", {adjustment["sigma0"].Decimals(3)}),
                  Row("NIS of the GNSS positions (1: as stated)",
                      {smooth["innovations"]["gnss position"]["nis"].Decimals(3)}),
                  Row("GNSS epochs", {adjustment["gnss_epochs"].Count()})};
  if (smooth["accuracy"]) {
    headline.figures.push_back(AccuracyTable(smooth["accuracy"], consistent));
  }
  if (smooth["separation"]) headline.figures.push_back(FilterSeparationTable(smooth["separation"]));
  headline.figures.push_back(figures);
  headline.next =
      consistent ? std::vector<std::string>{"dn calibrate FLIGHT --out DIR, for the boresight."}
                 : std::vector<std::string>{
                       "dn gap FLIGHT --out DIR names the cause.",
                       "Check what the first reason names: lever arms, clocks, stated noise."};
  return headline;
}

}  // namespace

Document SmoothPage(const ResultFolder& folder) {
  const Facts smooth = folder.Read("smooth.json");
  Document document = Begin(folder, smooth["flight"].text(), "smoothed trajectory");
  document.headlines = {SmoothHeadline(smooth)};
  Append(ModelCheckSection(smooth), &document);
  Append(TrajectorySection(folder), &document);
  Append(BiasSection(folder), &document);
  Append({"Adjustment", {AdjustmentTable(smooth["adjustment"])}, true}, &document);
  Append(StatisticsSection(smooth["innovations"], smooth["residuals"]), &document);
  return document;
}

}  // namespace dn::page_internal
