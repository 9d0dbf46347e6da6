#include <dn/axis_names.h>
#include <dn/error.h>
#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

// Two points per pixel of a wide chart.
constexpr std::size_t kMostPoints = 1200;
constexpr std::size_t kMostListed = 200000;

std::string Shortened(const std::string& text) {
  if (text.size() <= kMostListed) return text;
  return text.substr(0, kMostListed) + "\n... (the file has the rest)\n";
}

Table Pairs(const std::string& title, const Facts& object) {
  Table table{title, {"", ""}, {}};
  for (const std::string& key : object.keys()) {
    const Facts value = object[key];
    const std::string text = value.text();
    table.rows.push_back(Row(key, {text.empty() ? value.Significant(10) : Text(text)}));
  }
  return table;
}

/// Returns the first digits of a hash. Two files share them by chance once in 2^48.
std::string Brief(const std::string& hash) { return hash.substr(0, 12); }

Table Inputs(const Facts& inputs) {
  Table table{"Inputs", {"file", "bytes", "SHA-256 begins"}, {}};
  for (const Facts& input : inputs.elements()) {
    table.rows.push_back(
        Row(input["file"].text(), {input["bytes"].Count(), Text(Brief(input["sha256"].text()))}));
  }
  return table;
}

/// Returns the hashes in the format of sha256sum -c, to be checked in the folder of the flight.
Listing Hashes(const Facts& inputs) {
  Listing listing{"SHA-256 of the inputs", ""};
  for (const Facts& input : inputs.elements()) {
    listing.text += input["sha256"].text() + "  " + input["file"].text() + "\n";
  }
  return listing;
}

}  // namespace

Table AngleTable(const std::string& title) {
  Table table{title, AxisNames(kRollPitchYaw), {}};
  table.columns.insert(table.columns.begin(), "");
  return table;
}

std::vector<Cell> Row(std::string name, std::vector<Cell> cells) {
  cells.insert(cells.begin(), Text(std::move(name)));
  return cells;
}

std::vector<Cell> Three(const Facts& list, int decimals, double scale) {
  std::vector<Cell> cells;
  for (std::size_t k = 0; k < 3; ++k) cells.push_back(list[k].Decimals(decimals, scale));
  return cells;
}

Table ContributionTable(const Facts& boresight, std::size_t most) {
  Table table{"", {"effect", "roll [mdeg]", "pitch", "yaw", "smaller by"}, {}};
  for (const Facts& part : boresight["contributions"].elements()) {
    if (table.rows.size() == most) break;
    std::vector<Cell> cells = Three(part["sigma_deg"], 2, 1e3);
    cells.push_back(Text(part["remedy"].text()));
    table.rows.push_back(Row(part["effect"].text(), std::move(cells)));
  }
  return table;
}

std::vector<Cell> PureModelRow(const Facts& boresight) {
  std::vector<Cell> cells = Three(boresight["as_modelled"]["sigma_deg"], 2, 1e3);
  cells.push_back(Text(""));
  return Row("pure model", std::move(cells));
}

HeatMap Correlations(const std::string& title, const std::vector<std::string>& rows,
                     const std::vector<std::string>& columns, const Facts& matrix) {
  constexpr std::size_t kMostFields = 100'000;
  if (rows.size() * columns.size() > kMostFields) {
    throw InvalidInput(title + ": more fields than a page can show");
  }
  HeatMap map{title, rows, columns, {}};
  for (std::size_t r = 0; r < rows.size(); ++r) {
    map.values.emplace_back();
    for (std::size_t c = 0; c < columns.size(); ++c) {
      map.values.back().push_back(matrix[r][c].number());
    }
  }
  return map;
}

std::vector<double> Column(const TextTable& table, std::size_t column, double minus) {
  std::vector<double> values;
  values.reserve(table.rows());
  for (std::size_t k = 0; k < table.rows(); ++k) values.push_back(table.row(k)[column] - minus);
  return values;
}

Curve OnScreen(const Curve& curve) { return ThinCurve(curve, kMostPoints); }

void Append(Section section, Document* document) {
  if (!section.contents.empty()) document->sections.push_back(std::move(section));
}

void Explain(const std::map<std::string, Meaning>& meanings, const std::string& verdict,
             Headline* headline) {
  const auto known = meanings.find(verdict);
  if (known == meanings.end()) return;
  headline->answer = known->second.answer;
  headline->tone = known->second.tone;
  headline->next = known->second.next;
}

Document Begin(const ResultFolder& folder, const std::string& name, const std::string& what) {
  Document document;
  document.title = name + ": " + what;
  document.subtitle = "dn " + folder.report()["versions"]["dn"].text();
  return document;
}

Table AdjustmentTable(const Facts& adjustment) {
  Table table{"Adjustment", {"", ""}, {}};
  for (const std::string& key : adjustment.keys()) {
    if (adjustment[key]) table.rows.push_back(Row(key, {adjustment[key].Significant(7)}));
  }
  return table;
}

Section StatisticsSection(const Facts& innovations, const Facts& residuals) {
  Section section{"Innovations and residuals", {}, true};
  const auto add = [&](const std::string& title, const Facts& sensors, const std::string& note) {
    Table table{title,
                {"sensor", "axis", "count", "mean", "variance", "expected", "lag-1",
                 "worst [sigma]", "at [s]"},
                {},
                note};
    for (const std::string& sensor : sensors.keys()) {
      for (const std::string& axis : sensors[sensor].keys()) {
        const Facts one = sensors[sensor][axis];
        if (!one["count"]) continue;
        table.rows.push_back({Text(sensor), Text(axis), one["count"].Count(),
                              one["mean"].Decimals(3), one["variance"].Significant(4),
                              one["expected_variance"].Significant(4),
                              one["lag1_correlation"].Decimals(3), one["worst"].Decimals(2),
                              one["worst_t_s"].Decimals(2)});
      }
    }
    if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  };
  add("Innovations of the forward filter", innovations,
      "Normalised: mean 0, variance 1, white if the model is right.");
  add("Residuals after the adjustment", residuals,
      "Whitened: the variance is the expected one if the model is right.");
  return section;
}

std::vector<Section> RunSections(const ResultFolder& folder) {
  const Facts& report = folder.report();
  Section warnings{"Warnings", {}};
  for (const std::string& warning : report["warnings"].texts()) {
    warnings.contents.emplace_back(Paragraph{warning, Tone::kDoubtful});
  }
  Section run{"Data, settings and versions", {}, true};
  if (report["counts"]) {
    run.contents.emplace_back(Pairs("Kept and dropped", report["counts"]));
  }
  if (const Facts inputs = report["inputs"]; !inputs.elements().empty()) {
    run.contents.emplace_back(Inputs(inputs));
    run.contents.emplace_back(Hashes(inputs));
  }
  run.contents.emplace_back(Pairs("Versions", report["versions"]));
  const std::string settings = folder.Text("config.resolved.yaml");
  if (!settings.empty()) {
    run.contents.emplace_back(Listing{"Settings (config.resolved.yaml)", Shortened(settings)});
  }
  std::vector<Section> sections;
  if (!warnings.contents.empty()) sections.push_back(std::move(warnings));
  sections.push_back(std::move(run));
  return sections;
}

}  // namespace dn::page_internal
