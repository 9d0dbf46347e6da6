#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "sections.h"
#include "swath_map.h"

namespace dn::page_internal {
namespace {

// Columns of pair_residuals.txt.
enum PairColumn : std::size_t {
  kTime = 0,
  kGround = 3,
  kBefore = 5,
  kAfter = 8,
  kScanAngle = 11,
  kRange = 13,
  kHeading = 15,
  kColumns = 17,
};
constexpr std::size_t kMostDots = 600;  // per cloud
constexpr std::size_t kBins = 15;
constexpr double kFewest = 8.0;  // smallest number of pairs in a bin with a mean

Table StripPairs(const Facts& list) {
  Table table{"Differences of the pairs by pair of strips",
              {"strips", "pairs", "before: mean length [m]", "rms E [m]", "rms N", "rms U",
               "after: mean length [m]", "rms E [m]", "rms N", "rms U", "mean U"},
              {},
              "Before: with the assumed mounting on the trajectory of the result. After: with the "
              "result."};
  for (const Facts& of : list.elements()) {
    const Facts before = of["before"];
    const Facts after = of["after"];
    std::vector<Cell> row{Text(of["strips"].text()), of["pairs"].Count(),
                          before["mean_m"].Decimals(3)};
    const auto add = [&](const std::vector<Cell>& cells) {
      row.insert(row.end(), cells.begin(), cells.end());
    };
    add(Three(before["rms_enu_m"], 3));
    add({after["mean_m"].Decimals(3)});
    add(Three(after["rms_enu_m"], 3));
    add({after["mean_enu_m"][2].Decimals(4)});
    table.rows.push_back(std::move(row));
  }
  return table;
}

/// Returns the remaining difference of a pair along the course of its first end, across it (to the
/// right), and up.
std::array<double, 3> InTrack(const double* row) {
  const double heading_rad = row[kHeading] * std::numbers::pi / 180.0;
  const double east = row[kAfter];
  const double north = row[kAfter + 1];
  return {east * std::sin(heading_rad) + north * std::cos(heading_rad),
          east * std::cos(heading_rad) - north * std::sin(heading_rad), row[kAfter + 2]};
}

/// Returns the means of y over bins of x; the curve has gaps at bins with few values.
Curve BinMeans(const std::string& label, const std::vector<double>& x,
               const std::vector<double>& y) {
  const auto [least, most] = std::minmax_element(x.begin(), x.end());
  const double width = std::max(*most - *least, 1e-9) / kBins;
  std::array<double, kBins> sum_x{}, sum_y{}, count{};
  for (std::size_t k = 0; k < x.size(); ++k) {
    const auto bin = std::min(static_cast<std::size_t>((x[k] - *least) / width), kBins - 1);
    sum_x[bin] += x[k];
    sum_y[bin] += y[k];
    count[bin] += 1.0;
  }
  Curve means{label, {}, {}};
  for (std::size_t bin = 0; bin < kBins; ++bin) {
    const bool enough = count[bin] >= kFewest;
    const double middle = *least + (static_cast<double>(bin) + 0.5) * width;
    means.x.push_back(enough ? sum_x[bin] / count[bin] : middle);
    means.y.push_back(enough ? sum_y[bin] / count[bin] : std::numeric_limits<double>::quiet_NaN());
  }
  return means;
}

ScatterChart Against(const std::string& what, const TextTable& pairs, std::size_t column,
                     double minus) {
  ScatterChart chart{
      "Remaining differences of the pairs against " + what, what, "difference [m]", {}};
  const char* names[] = {"along track", "across track", "up"};
  const std::size_t step = pairs.rows() / kMostDots + 1;
  const std::vector<double> x = Column(pairs, column, minus);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    std::vector<double> y;
    Curve cloud{names[axis], {}, {}};
    for (std::size_t k = 0; k < pairs.rows(); ++k) {
      y.push_back(InTrack(pairs.row(k))[axis]);
      if (k % step != 0) continue;
      cloud.x.push_back(x[k]);
      cloud.y.push_back(y[k]);
    }
    chart.clouds.push_back(std::move(cloud));
    chart.curves.push_back(BinMeans(names[axis], x, y));
  }
  return chart;
}

PlacedDistances Placed(const TextTable& pairs) {
  PlacedDistances placed;
  for (std::size_t k = 0; k < pairs.rows(); ++k) {
    const double* row = pairs.row(k);
    placed.Add(row[kGround], row[kGround + 1],
               std::hypot(row[kBefore], row[kBefore + 1], row[kBefore + 2]),
               std::hypot(row[kAfter], row[kAfter + 1], row[kAfter + 2]));
  }
  return placed;
}

}  // namespace

Section PairSection(const ResultFolder& folder, const Facts& result, const std::string& suffix) {
  Section section{"Pairs before and after", {}};
  const Facts list = result["strip_pairs"];
  if (list.elements().empty()) return section;
  section.contents.emplace_back(StripPairs(list));
  if (!folder.Has("georef.json")) {
    section.contents.emplace_back(
        UsgsTable(list.elements().back()["after"]["rms_enu_m"][2].number(),
                  "These are differences of pairs, with the noise of their matching, and no "
                  "differences of surfaces: dn calibrate --georef compares the surfaces of the "
                  "strips."));
  }
  const auto pairs = folder.Numbers("pair_residuals" + suffix + ".txt", kColumns);
  if (!pairs) return section;
  const std::vector<double> t_s = Column(*pairs, kTime);
  const double start_s = *std::min_element(t_s.begin(), t_s.end());
  for (MapChart& map : DistanceMaps(folder, "Location of the pairs", Placed(*pairs))) {
    section.contents.emplace_back(Chart{std::move(map)});
  }
  section.contents.emplace_back(Paragraph{
      "A mean (line) that differs from zero in one of these charts is an error that a calibration "
      "should have removed."});
  for (const auto& [what, column, minus] : {std::tuple("scan angle [deg]", kScanAngle, 0.0),
                                            {"range [m]", kRange, 0.0},
                                            {"heading [deg]", kHeading, 0.0},
                                            {"time since the first pair [s]", kTime, start_s}}) {
    section.contents.emplace_back(Chart{Against(what, *pairs, column, minus)});
  }
  return section;
}

}  // namespace dn::page_internal
