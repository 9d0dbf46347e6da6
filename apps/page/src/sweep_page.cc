#include <dn/axis_names.h>

#include <algorithm>
#include <set>
#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

constexpr std::size_t kMostDesigns = 30;
constexpr std::size_t kMostKeys = 30;

double Largest(const Facts& design) { return design["sigma_deg"].vector3().maxCoeff(); }

std::string DesignName(const Facts& design) {
  std::string name;
  for (const std::string& label : design["labels"].texts()) {
    name += (name.empty() ? "" : ", ") + label;
  }
  return name;
}

/// Returns the designs that determine the boresight, sorted by the largest of the three sigmas.
std::vector<Facts> BestFirst(const Facts& sweep) {
  std::vector<Facts> designs = sweep["designs"].elements();
  std::erase_if(designs, [](const Facts& design) { return !(Largest(design) > 0.0); });
  std::stable_sort(designs.begin(), designs.end(),
                   [](const Facts& a, const Facts& b) { return Largest(a) < Largest(b); });
  return designs;
}

Headline SweepHeadline(const std::vector<Facts>& designs, std::size_t all) {
  Headline headline;
  headline.word = std::to_string(all) + " designs";
  headline.tone = designs.empty() ? Tone::kBad : Tone::kPlain;
  headline.answer = std::to_string(designs.size()) + " of them would determine the boresight." +
                    (designs.empty() ? "" : " The best: " + DesignName(designs.front()));
  if (designs.empty()) return headline;
  const Facts sigma = designs.front()["sigma_deg"];
  Table table = AngleTable("Best design");
  table.rows = {Row("sigma [mdeg]", Three(sigma, 2, 1e3))};
  headline.figures = {std::move(table)};
  return headline;
}

/// Draws the sigmas of the best design for each value of each key.
Section ByValue(const Facts& sweep, const std::vector<Facts>& designs) {
  Section section{"Best design for each value", {}};
  const std::vector<std::string> keys = sweep["keys"].texts();
  for (std::size_t key = 0; key < std::min(keys.size(), kMostKeys); ++key) {
    BarChart chart{"Best design with each value of " + keys[key], "sigma [mdeg]", {}};
    std::set<std::string> seen;
    for (const Facts& design : designs) {
      const std::string value = design["labels"][key].text();
      if (!seen.insert(value).second) continue;
      for (std::size_t k = 0; k < 3; ++k) {
        chart.bars.push_back(
            {value, kRollPitchYaw[k], 1e3 * design["sigma_deg"][k].number(), kNone, kNone});
      }
    }
    section.contents.emplace_back(Chart{std::move(chart)});
  }
  return section;
}

Section Designs(const Facts& sweep, const std::vector<Facts>& designs) {
  Section section{"Designs, best first", {}};
  BarChart chart{"Sigmas of the boresight", "sigma [mdeg]", {}};
  Table table{"", sweep["keys"].texts(), {}};
  for (const char* column : {"roll [mdeg]", "pitch", "yaw", "condition number",
                             "largest correlation", "trajectory roll, pitch [mdeg]"}) {
    table.columns.emplace_back(column);
  }
  for (std::size_t n = 0; n < std::min(designs.size(), kMostDesigns); ++n) {
    const Facts& design = designs[n];
    std::vector<Cell> row;
    for (const std::string& label : design["labels"].texts()) row.push_back(Text(label));
    for (std::size_t k = 0; k < 3; ++k) {
      chart.bars.push_back({DesignName(design), kRollPitchYaw[k],
                            1e3 * design["sigma_deg"][k].number(), kNone, kNone});
      row.push_back(design["sigma_deg"][k].Decimals(2, 1e3));
    }
    row.push_back(design["condition_number"].Significant(3));
    row.push_back(design["largest_correlation"].Decimals(3));
    row.push_back(design["trajectory_rp_deg"].Decimals(2, 1e3));
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) return section;
  if (designs.size() > kMostDesigns) table.note = "sweep.csv has the others.";
  section.contents = {Chart{std::move(chart)}, std::move(table)};
  return section;
}

Section Failures(const Facts& sweep) {
  Section section{"Designs that determine nothing", {}};
  Table table{"", {"design", "why"}, {}};
  for (const Facts& design : sweep["designs"].elements()) {
    const std::string why = design["singular"].text();
    if (why.empty() || table.rows.size() == kMostDesigns) continue;
    table.rows.push_back(Row(DesignName(design), {Text(why)}));
  }
  if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  return section;
}

}  // namespace

Document SweepPage(const ResultFolder& folder) {
  const Facts sweep = folder.Read("sweep.json");
  const std::vector<Facts> designs = BestFirst(sweep);
  Document document = Begin(folder, "sweep", "what would each design determine?");
  document.headlines = {SweepHeadline(designs, sweep["designs"].elements().size())};
  Append(Designs(sweep, designs), &document);
  if (!designs.empty()) Append(ByValue(sweep, designs), &document);
  Append(Failures(sweep), &document);
  return document;
}

}  // namespace dn::page_internal
