#include <dn/axis_names.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

constexpr std::size_t kMaxCauses = 15;
constexpr std::size_t kMaxStatistics = 30;
constexpr double kSigmasOfBand = 1.96;  // 95 %

/// Returns whether the diagnosis contains shifts of the boresight. It does not without pairs.
bool HasBoresight(const Facts& gap) {
  for (const char* list : {"causes", "could_still_hide"}) {
    for (const Facts& effect : gap[list].elements()) {
      const Eigen::Vector3d shift = effect["boresight_damage_mdeg"].vector3();
      if (!shift.isZero(0.0)) return true;
    }
  }
  return false;
}

/// Returns what each verdict means for the boresight, or for the trajectory of a flight without
/// pairs. The meanings agree with docs/guides/gap.md.
std::map<std::string, Meaning> GapMeanings(const std::string& result) {
  return {
      {"identified",
       {"The data differ from the model, and the named effects explain it.",
        Tone::kDoubtful,
        {"dn calibrate flight.adapted.yaml --out DIR, with the effects in the estimator.",
         "If you can measure the size or look it up, correct flight.yaml instead."}}},
      {"group",
       {"The data differ from the model. One of several effects explains it; this flight cannot "
        "separate them.",
        Tone::kDoubtful,
        {"Measure one of them, or fly what the reason proposes.",
         "The " + result + " depends on which of them is the cause."}}},
      {"partial",
       {"Do not rely on the " + result + ": no known effect explains a part of the gap.",
        Tone::kBad,
        {"Look at the first place under Where: a sensor, a strip or a time that differs."}}},
      {"unknown",
       {"Do not rely on the " + result +
            ": the data differ from the model, and no known effect explains it.",
        Tone::kBad,
        {"Look at the first place under Where: a sensor, a strip or a time that differs."}}},
      {"no_gap",
       {"The data agree with the assumed model.",
        Tone::kGood,
        {"Read which effects are undetectable, and decide whether you can accept their shift of "
         "the " +
         result + "."}}},
      {"unavailable",
       {"This flight cannot be diagnosed.",
        Tone::kDoubtful,
        {"Fly again, or add the data that the reason names."}}},
  };
}

Headline GapHeadline(const Facts& gap) {
  const Facts verdict = gap["verdict"];
  Headline headline;
  const std::string kind = verdict["kind"].text();
  headline.word = kind == "no_gap" ? "no gap" : kind;
  headline.reasons = {verdict["text"].text()};
  if (verdict["tie_breaker"]) headline.reasons.push_back(verdict["tie_breaker"].text());
  Explain(GapMeanings(HasBoresight(gap) ? "boresight" : "trajectory"), kind, &headline);
  const Facts size = gap["gap"]["size_nats_per_obs"];
  const Facts units = gap["gap"]["user_units"];
  Table figures{"The gap", {"", ""}, {}};
  figures.rows = {
      Row("p-value: probability of such data without a gap",
          {gap["gap"]["p_value"].Significant(2)}),
      Row("size [nats per observation]", {size["value"].Significant(3)}),
      Row("95 % upper limit", {size["upper_limit_95"].Significant(3)}),
      Row("excess of the pairs over their noise [mm]", {units["p2p_excess_mm"].Decimals(1)}),
      Row("excess of GNSS over its noise [mm]", {units["gnss_excess_mm"].Decimals(1)}),
      Row("boresight between strip pairs [mdeg]",
          {units["boresight_inconsistency_mdeg"].Decimals(2)})};
  headline.figures = {figures};
  return headline;
}

std::string DiscrepancyName(const Facts& one) {
  const std::string name = one["name"].text();
  if (one["period_s"]) return fmt::format("{}, {:.0f} s", name, one["period_s"].number());
  return one["tau_s"] ? fmt::format("{}, tau {:.0f} s", name, one["tau_s"].number()) : name;
}

Section Causes(const Facts& gap) {
  Section section{"Causes", {}};
  BarChart chart{"Evidence for each effect, with its probability", "log evidence [nats]", {}};
  Table table{
      "",
      {"effect", "probability", "nats", "shift roll [mdeg]", "pitch", "yaw", "share absorbed",
       "usual sigmas", "size"},
      {},
      "Best explanation first. Shift: change of the boresight if the effect is present and not "
      "modelled. Share absorbed: the part that trajectory, biases and boresight absorb. It is "
      "not visible in the residuals. Usual sigmas: size in sigmas of its prior; up to 4 it is a "
      "tolerance of the sensor, beyond a fault."};
  for (const Facts& cause : gap["causes"].elements()) {
    const std::string name = cause["effect"].text();
    if (chart.bars.size() < kMaxCauses) {
      chart.bars.push_back({fmt::format("{} ({:.2f})", name, cause["posterior"].number()), "",
                            cause["log_evidence"].number(), kNone, kNone});
    }
    std::vector<Cell> row{Text(name), cause["posterior"].Decimals(2),
                          cause["log_evidence"].Decimals(1)};
    for (const Cell& cell : Three(cause["boresight_damage_mdeg"], 2)) row.push_back(cell);
    row.push_back(cause["absorbed_fraction"].Decimals(2));
    row.push_back(cause["prior_sigmas"].Decimals(1));
    row.push_back(Text(EffectSize(cause)));
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) return section;
  section.contents = {Chart{std::move(chart)}, std::move(table)};
  Table nameless{"Unmodelled discrepancies", {"", "probability", "nats"}, {}};
  for (const Facts& one : gap["discrepancies"].elements()) {
    nameless.rows.push_back(
        Row(DiscrepancyName(one), {one["posterior"].Decimals(3), one["log_evidence"].Decimals(1)}));
  }
  if (gap["outside"]) {
    nameless.rows.push_back(Row("something that is not in the library, altogether",
                                {gap["outside"]["posterior"].Decimals(3), Text("")}));
  }
  if (!nameless.rows.empty()) section.contents.emplace_back(std::move(nameless));
  return section;
}

Section Where(const Facts& gap) {
  Section section{"Where", {}};
  Table table{"",
              {"sensor", "quantity", "place", "statistic", "p-value"},
              {},
              "p-values are corrected for the number of places. A large p means that no place is "
              "significant."};
  for (const Facts& place : gap["where"].elements()) {
    table.rows.push_back({Text(place["sensor"].text()), Text(place["quantity"].text()),
                          Text(place["location"].text()), place["statistic"].Decimals(2),
                          place["p_adjusted"].Significant(2)});
  }
  if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  return section;
}

Section Closed(const Facts& gap) {
  Section section{"How far the effects close the gap", {}};
  const Facts closed = gap["shrinkage"];
  if (!closed) return section;
  Table table{"", {"", "before", "after"}, {}};
  const auto add = [&](const std::string& name, const std::string& key) {
    if (!closed[key + "_before"]) return;
    table.rows.push_back(
        Row(name, {closed[key + "_before"].Significant(3), closed[key + "_after"].Significant(3)}));
  };
  add("p", "p");
  add("size [nats per observation]", "size");
  add("pairs [mm]", "p2p_mm");
  add("GNSS [mm]", "gnss_mm");
  for (std::size_t k = 0; k < 3; ++k) {
    const Facts before = closed["boresight_before_deg"][k];
    if (!before) continue;
    table.rows.push_back(Row(std::string("boresight ") + kRollPitchYaw[k] + " [deg]",
                             {before.Decimals(5), closed["boresight_after_deg"][k].Decimals(5)}));
  }
  Table figures{"", {"", ""}, {}};
  figures.rows = {Row("closed part of the gap (1: all)", {closed["fraction"].Decimals(2)}),
                  Row("95 % interval from", {closed["interval_95"][0].Decimals(2)}),
                  Row("to", {closed["interval_95"][1].Decimals(2)}),
                  Row("gain on held-out data [nats]", {closed["held_out_gain_nats"].Decimals(1)})};
  section.contents = {std::move(figures), std::move(table)};
  return section;
}

Section Averaged(const Facts& gap) {
  Section section{"Boresight over all hypotheses", {}};
  const Facts averaged = gap["boresight_averaged"];
  if (!averaged) return section;
  Table table{"",
              {"", "angle [deg]", "sigma [deg]"},
              {},
              "Mean over no effect, each effect and each discrepancy, by their probabilities. The "
              "sigma contains what they differ by."};
  for (std::size_t k = 0; k < 3; ++k) {
    table.rows.push_back(Row(kRollPitchYaw[k], {averaged["angles_deg"][k].Decimals(5),
                                                averaged["sigma_deg"][k].Decimals(5)}));
  }
  section.contents = {std::move(table)};
  return section;
}

double Deviation(const Facts& statistic) {
  return (statistic["value"].number() - statistic["null_mean"].number()) /
         statistic["null_sigma"].number();
}

Section Fingerprint(const Facts& gap) {
  Section section{"Statistics that differ most from the model", {}, true};
  std::vector<Facts> all = gap["fingerprint"].elements();
  std::erase_if(all, [](const Facts& one) { return !std::isfinite(Deviation(one)); });
  std::stable_sort(all.begin(), all.end(), [](const Facts& a, const Facts& b) {
    return std::abs(Deviation(a)) > std::abs(Deviation(b));
  });
  if (all.size() > kMaxStatistics) all.resize(kMaxStatistics);
  if (all.empty()) return section;
  BarChart chart{"Statistics of the flight, with 95 % intervals of replicates",
                 "difference from the mean of the model [its sigmas]",
                 {}};
  for (const Facts& one : all) {
    const std::string name = one["name"].text();
    chart.bars.push_back({name, "flight", Deviation(one), -kSigmasOfBand, kSigmasOfBand});
    if (!one["twin_mean"]) continue;
    const double sigma = one["null_sigma"].number();
    const double mean = (one["twin_mean"].number() - one["null_mean"].number()) / sigma;
    const double half = kSigmasOfBand * one["twin_sigma"].number() / sigma;
    chart.bars.push_back({name, "replicates with the effects", kNone, mean - half, mean + half});
  }
  section.contents.emplace_back(Chart{std::move(chart)});
  return section;
}

Section Validity(const Facts& gap) {
  Table table{"", {"", ""}, {}};
  const Facts validity = gap["validity"];
  for (const std::string& key : validity.keys()) {
    if (validity[key] && validity[key].elements().empty() && key != "notes") {
      table.rows.push_back(Row(key, {validity[key].Significant(6)}));
    }
  }
  Section section{"Reliability of the diagnosis", {std::move(table)}, true};
  for (const std::string& note : validity["notes"].texts()) {
    section.contents.emplace_back(Paragraph{note});
  }
  return section;
}

}  // namespace

Document GapPage(const ResultFolder& folder) {
  const Facts gap = folder.Read("gap.json");
  Document document = Begin(folder, gap["flight"].text(), "do the data agree with the model?");
  document.headlines = {GapHeadline(gap)};
  for (Section section :
       {Closed(gap), Averaged(gap), Causes(gap), UndetectableSection(gap["could_still_hide"]),
        Where(gap), TrajectorySection(folder), Fingerprint(gap), Validity(gap)}) {
    Append(std::move(section), &document);
  }
  return document;
}

}  // namespace dn::page_internal
