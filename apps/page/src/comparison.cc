#include "comparison.h"

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/page/page.h>
#include <fmt/format.h>

#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

// Significance level of three sigma, chosen as in the comparison of two methods.
constexpr double kSignificantDifference = 0.0027;

BoresightResult ReadBoresight(const Facts& result) {
  BoresightResult out;
  out.angles_rad = result["boresight"]["angles_deg"].vector3() * kRadPerDeg;
  out.covariance_rad2 =
      result["boresight"]["covariance_deg2"].matrix3() * (kRadPerDeg * kRadPerDeg);
  return out;
}

/// Returns whether a is the Gauss-Helmert result of the flight that the network of b has adjusted.
bool AreOneFlight(const Facts& a, const Facts& b) {
  return a["method"].text() == "gh" && b["method"].text() == "dn" &&
         a["flight"].text() == b["flight"].text();
}

struct Difference {
  MethodDifference values;
  std::string covariance;  // how the covariance was computed
};

Difference Between(const Facts& a, const Facts& b) {
  if (AreOneFlight(a, b)) return {Compare(ReadBoresight(a), ReadBoresight(b)), "of nested data"};
  if (AreOneFlight(b, a)) {
    Difference difference{Compare(ReadBoresight(b), ReadBoresight(a)), "of nested data"};
    difference.values.difference_rad = -difference.values.difference_rad;
    return difference;
  }
  return {CompareIndependent(ReadBoresight(a), ReadBoresight(b)), "independent"};
}

}  // namespace

Table DifferenceTable(const std::vector<std::pair<std::string, Facts>>& named) {
  Table table{
      "Difference of the boresight",
      {"", "roll [mdeg]", "sigma", "pitch [mdeg]", "sigma", "yaw [mdeg]", "sigma", "p-value", "",
       "covariances"},
      {},
      "A difference is significant if p < 0.0027 for the chi-square of all three angles (three "
      "sigma). Nested data: the dynamic network uses all data of the Gauss-Helmert adjustment of "
      "the same flight, and more. The covariance of the difference is then that of the adjustment "
      "minus that of the network (Hausman 1978). Independent: the covariances are added; the sum "
      "is too large if the results share data."};
  constexpr double kMdeg = 1e3 * kDegPerRad;
  for (std::size_t a = 0; a < named.size(); ++a) {
    for (std::size_t b = a + 1; b < named.size(); ++b) {
      const Difference difference = Between(named[a].second, named[b].second);
      const Eigen::Vector3d sigma_rad = difference.values.sigma_rad();
      std::vector<Cell> row{Text(named[a].first + " − " + named[b].first)};
      for (Eigen::Index k = 0; k < 3; ++k) {
        row.push_back(
            {Number{kMdeg * difference.values.difference_rad[k], 3, Number::Style::kDecimals}});
        row.push_back({Number{kMdeg * sigma_rad[k], 3, Number::Style::kDecimals}});
      }
      const bool differ = difference.values.p_value < kSignificantDifference;
      row.push_back({Number{difference.values.p_value, 2}});
      row.push_back(
          Text(differ ? "significant" : "not significant", differ ? Tone::kBad : Tone::kGood));
      row.push_back(Text(difference.covariance));
      table.rows.push_back(std::move(row));
    }
  }
  return table;
}

Document ComparisonPage(const std::vector<std::filesystem::path>& folders) {
  Document document;
  document.title = "Comparison of results";
  std::vector<std::pair<std::string, Facts>> named;
  for (const std::filesystem::path& path : folders) {
    const ResultFolder folder(path);
    const std::vector<Calibrated> all = CalibrationsIn(folder);
    for (const Calibrated& one : all) {
      const std::string name =
          path.string() + (all.size() > 1 ? " (" + one.result["method"].text() + ")" : "");
      named.emplace_back(name, one.result);
    }
    for (Headline& headline : MakePage(path).headlines) {
      headline.word = path.string() + ": " + headline.word;
      headline.next.clear();
      document.headlines.push_back(std::move(headline));
    }
  }
  if (named.size() > 1) Append({"Do they agree?", {DifferenceTable(named)}}, &document);
  return document;
}

}  // namespace dn::page_internal
