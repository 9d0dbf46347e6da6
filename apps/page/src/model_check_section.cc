#include <dn/effects/effect_table.h>
#include <dn/report/value_words.h>
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

// Significance level of a family of tests, as in the model check.
constexpr double kSignificantMisfit = 0.001;

Tone PValueTone(const Facts& p_value) {
  return p_value.number() < kSignificantMisfit ? Tone::kDoubtful : Tone::kPlain;
}

Cell Toned(Cell cell, Tone tone) {
  cell.tone = tone;
  return cell;
}

Table Groups(const Facts& check) {
  Table table{"Groups of observations",
              {"group", "observations", "redundancy", "variance ratio", "p-value", "worst [sigma]",
               "at [s]"},
              {},
              "Variance ratio: sum of squares over redundancy, 1 if the stated noise is right. "
              "p-values are corrected for the number of tests of the flight."};
  for (const Facts& group : check["groups"].elements()) {
    const Facts worst = group["worst"];
    table.rows.push_back({Text(group["name"].text()), group["observations"].Count(),
                          group["redundancy"].Decimals(1), group["variance_ratio"].Significant(4),
                          Toned(group["p_value"].Significant(2), PValueTone(group["p_value"])),
                          worst["standardised"].Decimals(2), worst["t_s"].Decimals(2)});
  }
  return table;
}

std::vector<Cell> EffectRow(const Facts& effect) {
  std::vector<Cell> cells{Text(effect["effect"].text()), effect["p_value"].Significant(2),
                          effect["log_evidence"].Decimals(1)};
  for (const Cell& cell : Three(effect["boresight_damage_mdeg"], 2)) cells.push_back(cell);
  cells.push_back(Text(EffectSize(effect)));
  return cells;
}

Table Effects(const Facts& check) {
  Table table{"Effects that the model lacks",
              {"effect", "p-value", "nats", "shift roll [mdeg]", "pitch", "yaw", "size"},
              {}};
  for (const Facts& effect : check["effects"].elements()) table.rows.push_back(EffectRow(effect));
  return table;
}

Table Departures(const Facts& check) {
  Table table{"Differences of laser vectors that no effect explains",
              {"discrepancy", "chi-square", "degrees of freedom", "p-value"},
              {},
              "Tested with the effects above, against the noise that the pairs show. p-values are "
              "corrected for the number of tests of the flight."};
  for (const Facts& discrepancy : check["departures"].elements()) {
    table.rows.push_back(
        {Text(discrepancy["name"].text()), discrepancy["statistic"].Decimals(1),
         discrepancy["dof"].Count(),
         Toned(discrepancy["p_value"].Significant(2), PValueTone(discrepancy["p_value"]))});
  }
  return table;
}

Table Unseen(const Facts& check) {
  Table table{"Undetectable effects of typical size",
              {"effect", "typical size", "detectable from", "unit", "shift roll [mdeg]", "pitch",
               "yaw", "[sigma]"},
              {},
              "This flight would not show these effects, although they would shift the result by "
              "more than its sigma. The geometry alone decides, whether they are present or not."};
  for (const Facts& undetectable : check["unseen"].elements()) {
    std::vector<Cell> cells{
        Text(undetectable["effect"].text() + " " + undetectable["component"].text()),
        undetectable["usual"].Significant(2), undetectable["minimal_detectable"].Significant(2),
        Text(undetectable["unit"].text())};
    for (const Cell& cell : Three(undetectable["boresight_damage_mdeg"], 2)) cells.push_back(cell);
    cells.push_back(undetectable["damage_sigmas"].Decimals(1));
    table.rows.push_back(std::move(cells));
  }
  return table;
}

Table Clocks(const Facts& clocks) {
  Table table{"Clocks against that of the inertial data",
              {"sensor", "offset [ms]", "sigma", "drift [ppm]", "sigma"},
              {},
              "tag = t + offset + drift (t - first epoch)"};
  for (const std::string& sensor : clocks.keys()) {
    const Facts clock = clocks[sensor];
    if (!clock) continue;
    table.rows.push_back(
        Row(sensor, {clock["offset_s"].Decimals(3, 1e3), clock["sigma_offset_s"].Decimals(3, 1e3),
                     clock["drift_ppm"].Decimals(3), clock["sigma_drift_ppm"].Decimals(3)}));
  }
  return table;
}

}  // namespace

std::string EffectSize(const Facts& effect) {
  const EffectSpec* spec = FindEffect(effect["effect"].text());
  std::string text;
  for (std::size_t k = 0; k < effect["estimate"].elements().size(); ++k) {
    const double sigma = effect["sigma"][k].number();
    const double value = effect["estimate"][k].number();
    if (k > 0) text += ", ";
    text +=
        std::isfinite(sigma) ? FormatWithSigma(value, sigma, "±") : fmt::format("{:.3g}", value);
    const bool own_unit = spec != nullptr && k < spec->components.size();
    const std::string unit = own_unit ? spec->components[k].unit : effect["unit"].text();
    if (unit != "1") text += " " + unit;
  }
  return text;
}

std::vector<std::string> FirstReasons(const Facts& assessment) {
  constexpr std::size_t kMaxPrinted = 3;
  std::vector<std::string> reasons = assessment["reasons"].texts();
  if (reasons.size() <= kMaxPrinted) return reasons;
  const std::size_t more = reasons.size() - kMaxPrinted;
  reasons.resize(kMaxPrinted);
  reasons.push_back(fmt::format("and {} more, below", more));
  return reasons;
}

Section ModelCheckSection(const Facts& result) {
  Section section{"Does the model fit the data?", {}};
  const Facts check = result["model_check"];
  if (!check) return section;
  for (const Facts& finding : check["findings"].elements()) {
    section.contents.emplace_back(Paragraph{
        finding["text"].text(), finding["contradicts"].flag() ? Tone::kBad : Tone::kDoubtful});
  }
  if (section.contents.empty()) {
    section.contents.emplace_back(
        Paragraph{"No test of the model check rejects the assumed model.", Tone::kGood});
  }
  for (Table table : {Effects(check), Departures(check), Unseen(check), Groups(check),
                      Clocks(result["clocks"])}) {
    if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  }
  return section;
}

}  // namespace dn::page_internal
