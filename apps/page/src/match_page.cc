#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "sections.h"
#include "swath_map.h"

namespace dn::page_internal {
namespace {

// Columns of matches/<a>_<b>.txt.
enum MatchColumn : std::size_t {
  kPlaceOfPair = 2,
  kApartBefore = 5,
  kApartAfter = 8,
  kMatchColumns = 15
};
constexpr std::size_t kMostMatchDots = 800;  // per cloud

struct CountStripPairs {
  std::string strips;  ///< "1-2"
  TextTable pairs;
};

std::string StripsText(const Facts& of) {
  return of["strips"][0].text() + "-" + of["strips"][1].text();
}

std::vector<CountStripPairs> ReadPairs(const ResultFolder& folder, const Facts& match) {
  std::vector<CountStripPairs> all;
  for (const Facts& of : match["strip_pairs"].elements()) {
    const std::string a = of["strips"][0].text(), b = of["strips"][1].text();
    auto pairs = folder.Numbers(fmt::format("matches/{}_{}.txt", a, b), kMatchColumns);
    if (pairs) all.push_back({fmt::format("{}-{}", a, b), std::move(*pairs)});
  }
  return all;
}

Headline MatchHeadline(const Facts& match) {
  Headline headline;
  const double pairs = match["counts"]["pairs"].number();
  headline.word = pairs > 0.0 ? "matched" : "no pairs";
  headline.tone = pairs > 0.0 ? Tone::kGood : Tone::kBad;
  headline.answer = pairs > 0.0
                        ? "Each pair is one ground point, within its covariance."
                        : "No ground patch of the overlaps could be matched in both strips.";
  const Facts all = match["misalignment"];
  if (all) {
    headline.figures = {
        Table{"",
              {"", ""},
              {Row("pairs", {match["counts"]["pairs"].Count()}),
               Row("distance before, rms [m]", {all["before"]["rms_m"].Decimals(3)}),
               Row("distance after, rms [m]", {all["after"]["rms_m"].Decimals(3)}),
               Row("ground sampling distance [m]", {match["gsd_m"].Decimals(2)})}}};
    headline.next = {
        "dn calibrate flight.matched.yaml of this folder: the boresight and its sigmas"};
  } else {
    headline.next = {
        "Find the stage at which the counts below fall to zero. A patch needs relief: slopes in "
        "several directions."};
  }
  return headline;
}

Table StagesTable(const Facts& match) {
  Table table{
      "Number of patches after each stage",
      {"strips", "overlap [m2]", "patches with relief", "clear in the rasters", "registered",
       "pairs", "evenness", "sigma, median [m]"},
      {},
      "Evenness: mean distance to the next pair, relative to that of random positions; below 1 in "
      "clusters. Sigma: three-dimensional, of a pair's difference."};
  for (const Facts& of : match["strip_pairs"].elements()) {
    const Facts counts = of["counts"];
    table.rows.push_back(
        Row(StripsText(of),
            {of["overlap_m2"].Decimals(0), counts["candidates"].Count(), counts["found"].Count(),
             counts["registered"].Count(), counts["pairs"].Count(), of["evenness"].Decimals(2),
             of["sigma_3d_median_m"].Decimals(3)}));
  }
  return table;
}

Table MisalignmentTable(const Facts& match) {
  Table table{"Distance between the strips",
              {"strips", "", "rms [m]", "median", "95 %", "mean E", "mean N", "mean U",
               "heading [deg]", "same direction"},
              {},
              "Point of the first strip minus point of the second. Same direction: 1 if all "
              "differences point the same way, near 0 if their directions are random."};
  for (const Facts& of : match["strip_pairs"].elements()) {
    if (!of["misalignment"]) continue;
    for (const char* when : {"before", "after"}) {
      const Facts apart = of["misalignment"][when];
      std::vector<Cell> row{Text(when), apart["rms_m"].Decimals(3), apart["median_m"].Decimals(3),
                            apart["p95_m"].Decimals(3)};
      for (const Cell& cell : Three(apart["mean_enu_m"], 3)) row.push_back(cell);
      row.push_back(apart["heading_deg"].Decimals(0));
      row.push_back(apart["same_direction"].Decimals(2));
      table.rows.push_back(Row(StripsText(of), std::move(row)));
    }
  }
  return table;
}

Section MatchSeparation(const Facts& match) {
  std::vector<Separation> separations;
  const auto add = [&](const std::string& strips, const Facts& misalignment) {
    separations.push_back({strips, "before", misalignment["before"]["separation"]});
    separations.push_back(
        {strips, "after one alignment of all strips", misalignment["after"]["separation"]});
  };
  for (const Facts& of : match["strip_pairs"].elements()) {
    add(StripsText(of), of["misalignment"]);
  }
  add("all", match["misalignment"]);
  return SeparationSection(separations);
}

Curve MakeCloud(const std::string& label, const TextTable& pairs, std::size_t column) {
  Curve cloud{label, {}, {}};
  const std::size_t step = pairs.rows() / kMostMatchDots + 1;
  for (std::size_t k = 0; k < pairs.rows(); k += step) {
    cloud.x.push_back(pairs.row(k)[column]);
    cloud.y.push_back(pairs.row(k)[column + 1]);
  }
  return cloud;
}

double Length(const double* v) { return std::hypot(v[0], v[1], v[2]); }

void Place(const TextTable& pairs, PlacedDistances* placed) {
  for (std::size_t k = 0; k < pairs.rows(); ++k) {
    const double* row = pairs.row(k);
    placed->Add(row[kPlaceOfPair], row[kPlaceOfPair + 1], Length(row + kApartBefore),
                Length(row + kApartAfter));
  }
}

void AddPictures(const ResultFolder& folder, const std::vector<CountStripPairs>& all,
                 Section* section) {
  PlacedDistances placed;
  ScatterChart before{"Differences before, seen from above", "east [m]", "north [m]", {}};
  ScatterChart after{"Differences after", "east [m]", "north [m]", {}};
  for (const CountStripPairs& of : all) {
    if (of.pairs.rows() == 0) continue;
    Place(of.pairs, &placed);
    before.clouds.push_back(MakeCloud(of.strips, of.pairs, kApartBefore));
    after.clouds.push_back(MakeCloud(of.strips, of.pairs, kApartAfter));
  }
  if (before.clouds.empty()) return;
  for (MapChart& map : DistanceMaps(folder, "Location of the pairs", placed)) {
    section->contents.emplace_back(Chart{std::move(map)});
  }
  section->contents.emplace_back(Chart{std::move(before)});
  section->contents.emplace_back(Chart{std::move(after)});
}

Table LevelsTable(const Facts& match) {
  Table table{"From coarse to fine",
              {"cell [m]", "search [m]", "places", "clear", "agree", "remaining, rms [m]",
               "roll [deg]", "pitch", "yaw"},
              {}};
  for (const Facts& level : match["levels"].elements()) {
    std::vector<Cell> row{level["cell_m"].Decimals(2), level["search_m"].Decimals(1),
                          level["places"].Count(),     level["found"].Count(),
                          level["agreeing"].Count(),   level["rms_m"].Decimals(2)};
    for (const Cell& cell : Three(level["boresight_deg"], 4)) row.push_back(cell);
    table.rows.push_back(std::move(row));
  }
  return table;
}

}  // namespace

Document MatchPage(const ResultFolder& folder) {
  const Facts match = folder.Read("match.json");
  const std::string flight = match["flight"].text();
  Document document = Begin(folder, flight.empty() ? "strips" : flight, "point pairs from strips");
  document.headlines = {MatchHeadline(match)};
  Section apart{"Strip against strip", {}};
  if (match["misalignment"]) {
    apart.contents.emplace_back(MisalignmentTable(match));
    AddPictures(folder, ReadPairs(folder, match), &apart);
  }
  Append(std::move(apart), &document);
  Append(MatchSeparation(match), &document);
  Append({"Stages", {StagesTable(match), LevelsTable(match)}}, &document);
  return document;
}

}  // namespace dn::page_internal
