#include <dn/axis_names.h>

#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

constexpr std::size_t kCorrelationColumns = 19;

Headline StudyHeadline(const Facts& study) {
  const bool observable = study["observable"].flag();
  Headline headline;
  headline.word = observable ? "observable" : "not observable";
  headline.tone = observable ? Tone::kGood : Tone::kBad;
  headline.answer = observable ? "This flight would determine the boresight to the sigmas below."
                               : "This flight would not determine the boresight.";
  headline.reasons = study["reasons"].texts();
  Table table{"Boresight", {"", "sigma [deg]", "sigma [mdeg]"}, {}};
  for (std::size_t k = 0; k < 3; ++k) {
    const Facts sigma = study["boresight"]["sigma_deg"][k];
    table.rows.push_back(Row(kRollPitchYaw[k], {sigma.Decimals(5), sigma.Decimals(2, 1e3)}));
  }
  headline.figures = {table};
  for (const Facts& weak : study["weak_directions"].elements()) {
    headline.next.push_back(weak["sigma_of"].text() + ": " + weak["remedy"].text());
  }
  return headline;
}

Section WeakDirections(const Facts& study) {
  Section section{"Weak directions", {}};
  for (const Facts& weak : study["weak_directions"].elements()) {
    Table table{"Weak: " + weak["sigma_of"].text(),
                {"", ""},
                {},
                "Cause: " + weak["cause"].text() + ". Remedy: " + weak["remedy"].text()};
    for (const std::string& name : weak["unknowns"].keys()) {
      table.rows.push_back(Row("weight of " + name, {weak["unknowns"][name].Decimals(3)}));
    }
    table.rows.push_back(
        Row("sigma [" + weak["unit"].text() + "]", {weak["sigma"].Significant(4)}));
    table.rows.push_back(
        Row("multiple correlation with the others", {weak["correlation"].Decimals(3)}));
    for (const std::string& name : weak["tried"].keys()) {
      table.rows.push_back(Row("sigma with " + name, {weak["tried"][name].Significant(4)}));
    }
    section.contents.emplace_back(std::move(table));
  }
  return section;
}

Section CorrelationsOverTime(const ResultFolder& folder) {
  Section section{"Correlation with the biases over time", {}, true};
  const auto numbers = folder.Numbers("correlations.txt", kCorrelationColumns);
  if (!numbers) return section;
  for (std::size_t angle = 0; angle < 3; ++angle) {
    SeriesChart chart{std::string("Correlation of ") + kRollPitchYaw[angle],
                      "time since start [s]",
                      "correlation",
                      {}};
    for (const auto& [sensor, first] : {std::pair("accelerometer ", 1), {"gyro ", 10}}) {
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const std::size_t column = static_cast<std::size_t>(first) + 3 * angle + axis;
        chart.curves.push_back(
            OnScreen({std::string(sensor) + kXyz[axis], Column(*numbers, 0, numbers->row(0)[0]),
                      Column(*numbers, column)}));
      }
    }
    section.contents.emplace_back(Chart{std::move(chart)});
  }
  return section;
}

Section Strips(const Facts& study) {
  Table table{"", {"strip", "course [deg]", "speed [m/s]", "height above ground [m]"}, {}};
  for (const Facts& strip : study["strips"].elements()) {
    table.rows.push_back(
        Row(strip["name"].text(), {strip["course_deg"].Decimals(1), strip["speed_m_s"].Decimals(1),
                                   strip["height_above_ground_m"].Decimals(0)}));
  }
  return {"Strips", {std::move(table)}};
}

}  // namespace

Document StudyPage(const ResultFolder& folder) {
  const Facts study = folder.Read("study.json");
  Document document = Begin(folder, study["flight"].text(), "what would this flight determine?");
  document.headlines = {StudyHeadline(study)};
  Append(WeakDirections(study), &document);
  Section boresight{"Boresight", {}};
  boresight.contents.emplace_back(
      Chart{Correlations("Correlation of the angles [%]", AxisNames(kRollPitchYaw),
                         AxisNames(kRollPitchYaw), study["boresight"]["correlation"])});
  Append(std::move(boresight), &document);
  Append(BeamSection(study), &document);
  Append(BiasCorrelationSection(study["correlations"]), &document);
  Append(CorrelationsOverTime(folder), &document);
  Append(UndetectableSection(study["could_still_hide"]), &document);
  Append(TrajectorySection(folder), &document);
  Append(Strips(study), &document);
  return document;
}

}  // namespace dn::page_internal
