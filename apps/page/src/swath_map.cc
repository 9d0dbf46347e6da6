#include "swath_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dn::page_internal {
namespace {

constexpr std::size_t kMaxPlaces = 1800;
constexpr double kOfAll = 0.98;  // share of the pairs inside the scale of colours

double ValueAtShare(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void AddDots(const PlacedPairs& pairs, const std::vector<double>& apart_m, MapChart* map) {
  const std::size_t step = pairs.east_m.size() / kMaxPlaces + 1;
  for (std::size_t k = 0; k < pairs.east_m.size(); k += step) {
    map->valued.x.push_back(pairs.east_m[k]);
    map->valued.y.push_back(pairs.north_m[k]);
    map->valued.value.push_back(apart_m[k]);
  }
}

}  // namespace

MapChart SwathMap(const ResultFolder& folder, const std::string& title) {
  MapChart map{title, {}};
  for (const Facts& swath : folder.Read("swaths.json")["swaths"].elements()) {
    const std::string label = "strip " + swath["strip"].text();
    Curve area = swath["outline_en_m"].points(label);
    Curve line = swath["line_en_m"].points(label);
    if (!area.x.empty()) map.areas.push_back(std::move(area));
    if (!line.x.empty()) map.lines.push_back(std::move(line));
  }
  return map;
}

void PlacedPairs::Add(double east, double north, double before, double after) {
  east_m.push_back(east);
  north_m.push_back(north);
  before_m.push_back(before);
  after_m.push_back(after);
}

std::vector<MapChart> PairMaps(const ResultFolder& folder, const PlacedPairs& pairs) {
  if (pairs.east_m.empty()) return {};
  std::vector<MapChart> maps;
  const double low_m = ValueAtShare(pairs.after_m, 1.0 - kOfAll);
  const double high_m = std::max(ValueAtShare(pairs.before_m, kOfAll), 2.0 * low_m);
  for (const auto& [when, apart_m] :
       {std::pair("before", &pairs.before_m), {"after", &pairs.after_m}}) {
    MapChart map = SwathMap(folder, std::string("Location of the pairs, ") + when);
    map.valued.label = std::string("apart ") + when + " [m]";
    map.valued.low = low_m;
    map.valued.high = high_m;
    AddDots(pairs, *apart_m, &map);
    maps.push_back(std::move(map));
  }
  return maps;
}

}  // namespace dn::page_internal
