#include <dn/axis_names.h>

#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

struct Sensor {
  const char* key;
  const char* name;
};
constexpr Sensor kSensors[] = {{"gyro", "Gyro"}, {"accel", "Accelerometer"}};

/// Returns the unit of white noise of the first axis that has white noise.
std::string WhiteUnit(const Facts& of) {
  for (const std::string axis : kXyz) {
    if (const Facts white = of[axis]["terms"]["white"]) return white["unit"].text();
  }
  return of["model"]["white"]["unit"].text();
}

Table Terms(const Sensor& sensor, const Facts& of) {
  Table table{std::string(sensor.name) + ": terms",
              {"axis", "white", "sigma", "Gauss-Markov", "sigma", "tau [s]", "sigma", "random walk",
               "sigma", "floor", "at [s]"},
              {},
              "White in " + WhiteUnit(of) + ", others in " + of["x"]["curve"]["unit"].text() +
                  ". A dash: the record does not show this term."};
  const auto add = [&](const std::string& name, const Facts& fit) {
    std::vector<Cell> row{Text(name)};
    for (const char* term : {"white", "gauss_markov", "gauss_markov_tau", "random_walk"}) {
      row.push_back(fit[term]["value"].Significant(4));
      row.push_back(fit[term]["sigma"].Significant(2));
    }
    row.push_back(fit["floor"]["deviation"].Significant(4));
    row.push_back(fit["floor"]["tau_s"].Significant(4));
    table.rows.push_back(std::move(row));
  };
  for (const std::string axis : kXyz) add(axis, of[axis]["terms"]);
  add("all", of["model"]);
  return table;
}

SeriesChart Deviations(const Sensor& sensor, const Facts& of) {
  SeriesChart chart{std::string(sensor.name) + ": Allan deviation, with a band of one sigma",
                    "cluster time [s]",
                    "[" + of["x"]["curve"]["unit"].text() + "]",
                    {},
                    true};
  for (const std::string axis : kXyz) {
    const Facts curve = of[axis]["curve"];
    Curve drawn{axis, {}, {}};
    for (std::size_t k = 0; k < curve["tau_s"].elements().size(); ++k) {
      const double deviation = curve["deviation"][k].number();
      const double sigma = curve["sigma"][k].number();
      if (!(deviation > sigma)) continue;  // logarithmic scales
      drawn.x.push_back(curve["tau_s"][k].number());
      drawn.y.push_back(deviation);
      drawn.low.push_back(deviation - sigma);
      drawn.high.push_back(deviation + sigma);
    }
    chart.curves.push_back(std::move(drawn));
  }
  return chart;
}

}  // namespace

Document AllanPage(const ResultFolder& folder) {
  const Facts allan = folder.Read("allan.json");
  Document document = Begin(folder, allan["file"].text(), "noise of a record at rest");
  Headline headline;
  const std::vector<std::string> warnings = folder.report()["warnings"].texts();
  headline.word = warnings.empty() ? "at rest" : "doubtful";
  headline.tone = warnings.empty() ? Tone::kGood : Tone::kDoubtful;
  headline.answer = warnings.empty() ? "The terms below describe the record."
                                     : "The terms below contain more than noise.";
  headline.reasons = warnings;
  headline.figures = {Table{"",
                            {"", ""},
                            {Row("values", {allan["values"].Count()}),
                             Row("rate [Hz]", {allan["rate_hz"].Significant(6)})}}};
  headline.next = {"noise.yaml contains them as a section of flight.yaml."};
  document.headlines = {std::move(headline)};
  for (const Sensor& sensor : kSensors) {
    const Facts of = allan[sensor.key];
    Section section{sensor.name, {Chart{Deviations(sensor, of)}, Terms(sensor, of)}};
    Append(std::move(section), &document);
  }
  const std::string yaml = folder.Text("noise.yaml");
  if (!yaml.empty()) Append({"For flight.yaml", {Listing{"noise.yaml", yaml}}}, &document);
  return document;
}

}  // namespace dn::page_internal
