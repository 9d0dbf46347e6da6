#include <fmt/format.h>

#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

std::vector<Cell> ShareRow(const std::string& name, const Facts& share) {
  return Row(name, {share["hits"].Count(), share["of"].Count(), share["share"].Decimals(1, 100.0),
                    share["interval_95"][0].Decimals(1, 100.0),
                    share["interval_95"][1].Decimals(1, 100.0)});
}

Table Shares(const std::string& title) {
  return {title, {"", "flights", "of", "[%]", "95 % from", "to"}, {}};
}

Bar ShareBar(const std::string& label, const std::string& group, const Facts& share) {
  const bool any = share["of"].number() > 0.0;
  return {label, group, any ? 100.0 * share["share"].number() : kNone,
          any ? 100.0 * share["interval_95"][0].number() : kNone,
          any ? 100.0 * share["interval_95"][1].number() : kNone};
}

Headline BlindHeadline(const Facts& score) {
  const Facts alarms = score["nothing"]["false_alarms"];
  const double allowed = score["nothing"]["allowed_95"][1].number();
  Headline headline;
  Table table = Shares("");
  table.rows = {ShareRow("no effect: false alarms", alarms),
                ShareRow("one effect: detected", score["one_effect"]["detected"]),
                ShareRow("one effect: named", score["one_effect"]["named"])};
  headline.figures = {std::move(table)};
  if (!(alarms["of"].number() > 0.0)) {
    headline.word = "scored";
    headline.answer = "Every flight has an effect: the false-alarm rate is unknown.";
    return headline;
  }
  const bool fine = alarms["share"].number() <= allowed;
  headline.word = fine ? "no more false alarms than allowed" : "too many false alarms";
  headline.answer = fine ? "The false-alarm rate is within its limit."
                         : "The false-alarm rate is above its limit.";
  headline.tone = fine ? Tone::kGood : Tone::kBad;
  return headline;
}

Section Power(const Facts& score) {
  Section section{"Power against size", {}};
  BarChart chart{"Flights with one effect", "share of the flights [%], with its 95 %", {}};
  Table table{"", {"size [typical sizes]", "flights", "detected", "named", "named with group"}, {}};
  const std::vector<Facts> sizes = score["by_size"].elements();
  for (std::size_t k = 0; k < sizes.size(); ++k) {
    const std::string from = fmt::format("{:.2g}", sizes[k]["from"].number());
    const std::string label = k + 1 < sizes.size()
                                  ? from + fmt::format(" to {:.2g}", sizes[k + 1]["from"].number())
                                  : "above " + from;
    table.rows.push_back(Row(
        label, {sizes[k]["detected"]["of"].Count(), sizes[k]["detected"]["hits"].Count(),
                sizes[k]["named"]["hits"].Count(), sizes[k]["named_with_group"]["hits"].Count()}));
    for (const auto& [key, name] : {std::pair("detected", "detected"),
                                    {"named", "named"},
                                    {"named_with_group", "named, or one of its group"}}) {
      chart.bars.push_back(ShareBar(label, name, sizes[k][key]));
    }
  }
  if (table.rows.empty()) return section;
  section.contents = {Chart{std::move(chart)}, std::move(table)};
  return section;
}

Section ByEffect(const Facts& score) {
  Section section{"By effect", {}, true};
  Table table{"", {"effect", "flights", "detected", "named", "named with group"}, {}};
  for (const Facts& one : score["by_effect"].elements()) {
    table.rows.push_back(
        Row(one["effect"].text(),
            {one["detected"]["of"].Count(), one["detected"]["hits"].Count(),
             one["named"]["hits"].Count(), one["named_with_group"]["hits"].Count()}));
  }
  if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  return section;
}

Section Reliability(const Facts& score) {
  Section section{"Are the probabilities calibrated?", {}};
  Curve there{"observed, with its 95 % interval", {}, {}};
  there.points = true;
  Table table{
      "", {"stated from", "to", "causes", "mean stated", "observed", "95 % from", "to"}, {}};
  for (const Facts& bin : score["reliability"].elements()) {
    const Facts share = bin["true"];
    if (!(share["of"].number() > 0.0)) continue;
    there.x.push_back(bin["stated"].number());
    there.y.push_back(share["share"].number());
    there.low.push_back(share["interval_95"][0].number());
    there.high.push_back(share["interval_95"][1].number());
    table.rows.push_back({bin["low"].Decimals(1), bin["high"].Decimals(1), share["of"].Count(),
                          bin["stated"].Decimals(3), share["share"].Decimals(3),
                          share["interval_95"][0].Decimals(3),
                          share["interval_95"][1].Decimals(3)});
  }
  if (table.rows.empty()) return section;
  section.contents = {Paragraph{"A stated probability is right if the same share of these causes "
                                "is present. The points then lie on the diagonal."},
                      Chart{SeriesChart{"Probability of a cause: stated and observed",
                                        "stated",
                                        "share",
                                        {{"perfect", {0.0, 1.0}, {0.0, 1.0}}, std::move(there)}}},
                      std::move(table)};
  return section;
}

Table Boresight(const Facts& boresight) {
  Table table{"Errors of the boresight by verdict of the calibration",
              {"", "verdict", "flights", "beyond 5 sigma", "rms [sigma]"},
              {}};
  for (const auto& [key, name] : {std::pair("assumed", "as assumed"), {"adapted", "as adapted"}}) {
    for (const Facts& one : boresight[key].elements()) {
      table.rows.push_back({Text(name), Text(one["verdict"].text()), one["flights"].Count(),
                            one["beyond_5_sigma"].Count(), one["rms_sigmas"].Significant(3)});
    }
  }
  return table;
}

}  // namespace

Document BlindPage(const ResultFolder& folder) {
  const Facts score = folder.Read("blind_check.json");
  Document document = Begin(folder, "blind check", "are the diagnoses right?");
  document.headlines = {BlindHeadline(score)};
  Table others = Shares("");
  others.rows = {
      ShareRow("no effect: an effect is named", score["nothing"]["false_names"]),
      ShareRow("two effects: detected", score["two_effects"]["detected"]),
      ShareRow("two effects: both named", score["two_effects"]["named"]),
      ShareRow("three effects: detected", score["three_effects"]["detected"]),
      ShareRow("three effects: all named", score["three_effects"]["named"]),
      ShareRow("effects outside the library: detected", score["outsider"]["detected"]),
      ShareRow("of these, called unknown", score["outsider"]["rejected_of_detected"]),
      ShareRow("sizes within their 95 % interval: fixed effects", score["coverage_95"]["fixed"]),
      ShareRow("sizes within their 95 % interval: stochastic effects",
               score["coverage_95"]["stochastic"])};
  Append(Power(score), &document);
  Append(Reliability(score), &document);
  Append({"Other shares", {std::move(others)}}, &document);
  Append({"Boresight", {Boresight(score["boresight"])}}, &document);
  Append(ByEffect(score), &document);
  return document;
}

}  // namespace dn::page_internal
