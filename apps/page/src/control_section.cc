#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

// Significance level of a family of tests, as in the model check.
constexpr double kWrongPointLevel = 0.001;

/// Returns the cells of east, north and up of a list of three values or one along a normal.
std::vector<Cell> Components(const Facts& list) {
  const bool three = list.elements().size() == 3;
  std::vector<Cell> cells;
  for (std::size_t k = 0; k < 3; ++k) {
    if (three) {
      cells.push_back(list[k].Decimals(3));
    } else {
      cells.push_back(k < 2 ? Text("–") : list[0].Decimals(3));
    }
  }
  return cells;
}

Table Points(const Facts& control) {
  Table table{
      "Laser minus survey [m]",
      {"point", "role", "east", "north", "up", "largest [sigma]", "p-value", "influence [mdeg]"},
      {},
      "The position by the laser is predicted from all other data, without the survey of "
      "the point itself. Planes and heights have one value, along the normal. Influence: "
      "the largest change of an angle of the boresight without the point."};
  for (const Facts& point : control["points"].elements()) {
    double largest = 0.0, influence = 0.0;
    for (const Facts& one : point["normalised"].elements()) {
      largest = std::max(largest, std::abs(one.number()));
    }
    for (const Facts& one : point["boresight_influence_mdeg"].elements()) {
      influence = std::max(influence, std::abs(one.number()));
    }
    std::vector<Cell> row{Text(point["name"].text()), Text(point["role"].text())};
    for (Cell& cell : Components(point["residual_m"])) row.push_back(std::move(cell));
    row.push_back(Text(fmt::format("{:.2f}", largest)));
    Cell p_value = point["p_value"].Significant(2);
    if (point["p_value"].number() < kWrongPointLevel) p_value.tone = Tone::kBad;
    row.push_back(std::move(p_value));
    row.push_back(Text(point["boresight_influence_mdeg"] ? fmt::format("{:.2f}", influence) : "–"));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table Accuracy(const Facts& accuracy) {
  Table table{"Accuracy by withheld checks (ASPRS, edition 2) [m]",
              {"", "accuracy", "checks", "RMSE of the checks", "accuracy of the checks", "mean"},
              {},
              "Accuracy: the root of the sum of the squares of the next two errors. The standard "
              "asks for at least 30 checks before an accuracy counts as tested."};
  for (const char* component : {"vertical", "horizontal"}) {
    const Facts one = accuracy[component];
    if (!one) continue;
    table.rows.push_back(Row(
        component, {one["combined_m"].Decimals(3), one["checks"].Count(), one["rmse_m"].Decimals(3),
                    one["survey_m"].Decimals(3), one["mean_m"].Decimals(3)}));
  }
  return table;
}

Table Shift(const Facts& shift) {
  const bool estimated = shift["estimated"].flag();
  Table table{estimated ? "Estimated shift of the control against GNSS [m]"
                        : "Shift of the control against GNSS that would fit best [m]",
              {"", "east", "north", "up"},
              {}};
  if (!shift) return table;
  table.rows.push_back(Row("shift", Three(shift["enu_m"], 3)));
  table.rows.push_back(Row("sigma", Three(shift["sigma_m"], 3)));
  return table;
}

}  // namespace

Section ControlSection(const Facts& result) {
  Section section{"How well do control and checks fit?", {}};
  const Facts control = result["control"];
  if (!control) return section;
  for (Table table :
       {Accuracy(control["accuracy"]), Points(control), Shift(control["datum_shift"])}) {
    if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  }
  return section;
}

}  // namespace dn::page_internal
