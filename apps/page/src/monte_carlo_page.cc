#include <dn/axis_names.h>

#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

constexpr std::size_t kErrorColumns = 4;
constexpr std::size_t kNeesColumns = 3;

std::vector<Cell> Judged(const std::string& name, const Facts& figure) {
  const bool inside = figure["ok"].flag();
  return Row(name, {figure["value"].Significant(4), figure["band_99"][0].Significant(4),
                    figure["band_99"][1].Significant(4),
                    Text(inside ? "inside" : "outside", inside ? Tone::kGood : Tone::kBad)});
}

Table Figures(const Facts& summary) {
  Table table{
      "99 % bands, valid if the covariances are correct", {"", "value", "from", "to", ""}, {}};
  const Facts boresight = summary["boresight"];
  const auto add = [&](const std::string& name, const Facts& figure) {
    if (figure) table.rows.push_back(Judged(name, figure));
  };
  add("boresight: NEES per degree of freedom", boresight["nees_per_dof"]);
  add("boresight: share within 1 sigma", boresight["coverage_1_sigma"]);
  add("within 2 sigmas", boresight["coverage_2_sigma"]);
  add("within 3 sigmas", boresight["coverage_3_sigma"]);
  add("chi-square per degree of freedom", summary["chi2_per_dof"]);
  add("share of flights with chi-square inside", summary["share_of_flights_with_chi2_inside"]);
  add("share of flights with the verdict contradicted", summary["share_of_flights_contradicted"]);
  return table;
}

Headline MonteCarloHeadline(const Facts& summary) {
  const bool consistent = summary["consistent"].flag();
  Headline headline;
  headline.word = consistent ? "consistent" : "not consistent";
  headline.tone = consistent ? Tone::kGood : Tone::kBad;
  headline.answer = consistent ? "The covariances agree with the true errors."
                               : "The covariances do not agree with the true errors: see the "
                                 "values outside their bands.";
  headline.reasons = summary["failures"].texts();
  headline.figures = {Figures(summary)};
  return headline;
}

Section Boresight(const ResultFolder& folder, const Facts& summary) {
  Section section{"Boresight", {}};
  if (!summary["boresight"]) return section;
  Table table = AngleTable("");
  const Facts boresight = summary["boresight"];
  table.rows = {Row("rms error [deg]", Three(boresight["rms_deg"], 6)),
                Row("mean sigma [deg]", Three(boresight["mean_sigma_deg"], 6)),
                Row("mean error [sigma]", Three(boresight["mean_sigmas"], 3))};
  section.contents.emplace_back(std::move(table));
  if (const auto errors = folder.Numbers("boresight_errors.txt", kErrorColumns)) {
    ScatterChart chart{"Errors of the flights", "seed", "error / sigma", {}};
    for (std::size_t k = 0; k < 3; ++k) {
      chart.clouds.push_back({kRollPitchYaw[k], Column(*errors, 0), Column(*errors, k + 1)});
    }
    section.contents.emplace_back(Chart{std::move(chart)});
  }
  return section;
}

Curve NeesCurve(const TextTable& nees, std::size_t number) {
  Curve curve{"NEES / 3", {}, {}};
  for (std::size_t k = 0; k < nees.rows(); ++k) {
    const double* row = nees.row(k);
    if (row[0] != static_cast<double>(number)) continue;
    curve.x.push_back(row[1]);
    curve.y.push_back(row[2]);
  }
  return curve;
}

Section Trajectory(const ResultFolder& folder, const Facts& summary) {
  Section section{"Trajectory", {}};
  const std::vector<Facts> quantities = summary["trajectory"].elements();
  Table table{
      "",
      {"", "NEES per degree of freedom", "share of epochs outside", "above", "rms [sigma]", "", ""},
      {},
      "If the covariances are correct, 1 % of the epochs lie outside on average."};
  for (const Facts& one : quantities) {
    std::vector<Cell> row{Text(one["quantity"].text()), one["nees_per_dof"].Decimals(3),
                          one["share_of_epochs_outside"].Decimals(3),
                          one["share_of_epochs_above"].Decimals(3)};
    for (const Cell& cell : Three(one["rms_sigmas"], 3)) row.push_back(cell);
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) return section;
  section.contents.emplace_back(std::move(table));
  const auto nees = folder.Numbers("trajectory_nees.txt", kNeesColumns);
  if (!nees) return section;
  const Facts band = quantities.front()["epoch_band_99"];
  for (std::size_t k = 0; k < quantities.size(); ++k) {
    Curve curve = NeesCurve(*nees, k + 1);
    if (curve.x.empty()) continue;
    Curve bounds{"99 % band", {curve.x.front(), curve.x.back()}, {1.0, 1.0}};
    bounds.low.assign(2, band[0].number());
    bounds.high.assign(2, band[1].number());
    section.contents.emplace_back(Chart{SeriesChart{quantities[k]["quantity"].text(),
                                                    "time since the first node [s]",
                                                    "NEES / 3",
                                                    {OnScreen(curve), bounds}}});
  }
  return section;
}

Section Sensors(const Facts& summary) {
  Section section{"Residuals and innovations", {}, true};
  for (const auto& [key, title] :
       {std::pair("residuals", "Residuals: mean square / expected"),
        {"innovations", "Innovations of the forward filter: mean square / expected"}}) {
    Table table{title, {"", "value", "from", "to", ""}, {}};
    for (const Facts& one : summary[key].elements()) {
      table.rows.push_back(
          Judged(one["sensor"].text() + ", " + one["axis"].text(), one["variance_ratio"]));
    }
    if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  }
  return section;
}

}  // namespace

Document MonteCarloPage(const ResultFolder& folder) {
  const Facts summary = folder.Read("monte_carlo.json");
  Document document =
      Begin(folder, folder.report()["scenario"].text(), "are the covariances right?");
  document.headlines = {MonteCarloHeadline(summary)};
  Append(Boresight(folder, summary), &document);
  Append(Trajectory(folder, summary), &document);
  Append(Sensors(summary), &document);
  return document;
}

}  // namespace dn::page_internal
