#include <dn/axis_names.h>

#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

constexpr double kBandSigmas = 2.0;

Table CommonAngles(const Facts& boresight) {
  Table table{
      "Boresight of all flights, a rotation vector about the body axes (forward, right, down)",
      {"", "angle [deg]", "sigma [mdeg]", "of it, effects that flights share [mdeg]"},
      {}};
  for (std::size_t k = 0; k < 3; ++k) {
    table.rows.push_back(
        Row(kRollPitchYaw[k],
            {boresight["angles_deg"][k].Decimals(5), boresight["sigma_deg"][k].Decimals(2, 1e3),
             boresight["shared_effects_sigma_deg"][k].Decimals(2, 1e3)}));
  }
  return table;
}

Headline FleetHeadline(const Facts& result) {
  const std::string verdict = result["assessment"]["verdict"].text();
  Headline headline;
  headline.word = verdict;
  headline.reasons = FirstReasons(result["assessment"]);
  headline.figures = {CommonAngles(result["boresight"])};
  if (verdict == "calibrated") {
    headline.tone = Tone::kGood;
    headline.answer = "You may rely on these angles within their sigmas, for all these flights.";
    headline.next = {"The forecast states the angles of the next flight."};
  } else if (verdict == "contradicted") {
    headline.tone = Tone::kBad;
    headline.answer = "Do not rely on one boresight for all these flights.";
    headline.next = {"Calibrate the flights before and after the change separately.",
                     "A mount that is taken off between flights: --across "
                     "'[{unknown: boresight, random_walk_deg: estimate}]'."};
  } else {
    headline.tone = verdict == "absorbed" ? Tone::kDoubtful : Tone::kBad;
    headline.answer = "Do not use these angles as those of the mounting.";
  }
  return headline;
}

/// Returns a chart of one angle over the flights: `value` and `sigma` are keys of a flight.
SeriesChart AngleChart(const Facts& result, std::size_t angle, const std::string& title,
                       const char* value, const char* sigma, double scale,
                       const std::string& unit) {
  Curve curve{"each flight, 2 sigma", {}, {}};
  for (const Facts& flight : result["flights"].elements()) {
    const double y = scale * flight[value][angle].number();
    const double band = kBandSigmas * scale * flight[sigma][angle].number();
    curve.x.push_back(static_cast<double>(curve.x.size() + 1));
    curve.y.push_back(y);
    curve.low.push_back(y - band);
    curve.high.push_back(y + band);
  }
  return {title, "flight", kRollPitchYaw[angle] + (" [" + unit + "]"), {std::move(curve)}};
}

Curve CommonBand(const Facts& result, std::size_t angle) {
  const double y = result["boresight"]["angles_deg"][angle].number();
  const double band = kBandSigmas * result["boresight"]["sigma_deg"][angle].number();
  const auto last = static_cast<double>(result["flights"].elements().size());
  return {"all flights, 2 sigma", {1.0, last}, {y, y}, {y - band, y - band}, {y + band, y + band}};
}

Section FlightsSection(const Facts& result) {
  Section section{"Angles over the flights", {}};
  for (std::size_t k = 0; k < 3; ++k) {
    SeriesChart chart =
        AngleChart(result, k, std::string(kRollPitchYaw[k]) + " of each flight alone", "angles_deg",
                   "sigma_deg", 1.0, "deg");
    chart.curves.push_back(CommonBand(result, k));
    section.contents.emplace_back(Chart{std::move(chart)});
  }
  return section;
}

Section StabilitySection(const Facts& result) {
  Section section{"Is the boresight stable?", {}};
  for (std::size_t k = 0; k < 3; ++k) {
    section.contents.emplace_back(Chart{
        AngleChart(result, k, std::string(kRollPitchYaw[k]) + ": each flight minus the others",
                   "change_deg", "change_sigma_deg", 1e3, "mdeg")});
  }
  const Facts stability = result["stability"], change = stability["likeliest_change"];
  Table table{"Tests",
              {"", "", "p-value"},
              {},
              "A change is named below p = 0.01, for the largest of all possible changes. Effects "
              "of the sensor are common to the flights and cancel as far as they act alike."};
  const bool single = change["kind"].text() == "single_flight";
  table.rows.push_back(
      Row("likeliest change", {Text((single ? "of flight " : "from flight ") +
                                    change["flight"].text() + (single ? " alone" : " on")),
                               stability["p_value"].Significant(2)}));
  table.rows.push_back(Row("all differences together", {stability["chi2"].Significant(4),
                                                        stability["chi2_p_value"].Significant(2)}));
  section.contents.emplace_back(std::move(table));
  Table size = AngleTable("The likeliest change");
  size.rows = {Row("change [mdeg]", Three(change["angles_deg"], 2, 1e3)),
               Row("sigma [mdeg]", Three(change["sigma_deg"], 2, 1e3)),
               Row("boresight after it [deg]", Three(change["after"]["angles_deg"], 5)),
               Row("sigma [mdeg]", Three(change["after"]["sigma_deg"], 2, 1e3))};
  section.contents.emplace_back(std::move(size));
  return section;
}

Table FlightTable(const Facts& result) {
  Table table{"Flights",
              {"flight", "from [s]", "verdict", "roll [deg]", "sigma [mdeg]", "pitch [deg]",
               "sigma [mdeg]", "yaw [deg]", "sigma [mdeg]", "p-value of its change"},
              {}};
  for (const Facts& flight : result["flights"].elements()) {
    std::vector<Cell> cells{flight["t0_s"].Decimals(1), Text(flight["verdict"].text())};
    for (std::size_t k = 0; k < 3; ++k) {
      cells.push_back(flight["angles_deg"][k].Decimals(5));
      cells.push_back(flight["sigma_deg"][k].Decimals(2, 1e3));
    }
    cells.push_back(flight["change_p_value"].Significant(2));
    table.rows.push_back(Row(flight["flight"].text(), std::move(cells)));
  }
  return table;
}

Table ExcludedTable(const Facts& result) {
  Table table{"Flights that are left out", {"flight", "reason"}, {}};
  for (const Facts& flight : result["excluded"].elements()) {
    table.rows.push_back(Row(flight["flight"].text(), {Text(flight["reason"].text())}));
  }
  return table;
}

/// Returns the section of the pairs between flights; empty without them.
Section TiesSection(const Facts& result) {
  const Facts ties = result["ties"];
  Section section{"Pairs between flights", {}};
  Table table{"Mean difference of the ends, as each flight alone determines them",
              {"strips", "used", "rejected", "east [m]", "north [m]", "up [m]", "sigma [m]", "", "",
               "p-value"},
              {},
              "A p-value below 0.001, for the largest of all strips, is a contradiction."};
  for (const Facts& strips : ties["strips"].elements()) {
    std::vector<Cell> cells{strips["used"].Decimals(0), strips["rejected"].Decimals(0)};
    for (const char* key : {"mean_enu_m", "sigma_enu_m"}) {
      for (std::size_t k = 0; k < 3; ++k) cells.push_back(strips[key][k].Decimals(3));
    }
    cells.push_back(strips["p_value"].Significant(2));
    table.rows.push_back(Row(strips["pairs"].text(), std::move(cells)));
  }
  if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  return section;
}

Section ForecastSection(const Facts& result) {
  const Facts forecast = result["forecast"], walk = forecast["random_walk"];
  Table table = AngleTable("The next flight");
  table.rows = {Row("constant boresight [deg]", Three(forecast["constant"]["angles_deg"], 5)),
                Row("sigma [mdeg]", Three(forecast["constant"]["sigma_deg"], 2, 1e3)),
                Row("with a random walk [deg]", Three(walk["angles_deg"], 5)),
                Row("sigma [mdeg]", Three(walk["sigma_deg"], 2, 1e3)),
                Row("sigma at the upper limit of the walk [mdeg]",
                    Three(walk["sigma_at_upper_limit_deg"], 2, 1e3))};
  Table size{"Random walk of the boresight, per flight and angle", {"", "sigma [mdeg]"}, {}};
  size.rows.push_back(Row(walk["step_stated"].flag() ? "as stated" : "of largest likelihood",
                          {walk["step_sigma_deg"].Decimals(3, 1e3)}));
  size.rows.push_back(Row("upper limit, 95 %", {walk["step_upper_limit_95_deg"].Decimals(3, 1e3)}));
  return {"Forecast", {std::move(table), std::move(size)}};
}

Section SharedSection(const Facts& result) {
  Table table = ContributionTable(result["boresight"]);
  table.title = "Effects that the flights share";
  table.note =
      "More flights make these parts of the sigmas smaller only as far as they show the effects.";
  table.rows.push_back(PureModelRow(result["boresight"]));
  return {"Sigmas", {std::move(table)}};
}

}  // namespace

Document FleetPage(const ResultFolder& folder) {
  const Facts result = folder.Read("result.json");
  Document document = Begin(folder, result["flight"].text(), "boresight calibration");
  document.headlines = {FleetHeadline(result)};
  Append(FlightsSection(result), &document);
  Append(StabilitySection(result), &document);
  Append(TiesSection(result), &document);
  Append(ForecastSection(result), &document);
  Section flights{"Flights", {FlightTable(result)}};
  Table excluded = ExcludedTable(result);
  if (!excluded.rows.empty()) flights.contents.emplace_back(std::move(excluded));
  Append(std::move(flights), &document);
  Append(SharedSection(result), &document);
  return document;
}

}  // namespace dn::page_internal
