#include "swath_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dn::page_internal {
namespace {

constexpr std::size_t kMaxPlaces = 1800;
constexpr double kOfAll = 0.98;  // share of the distances inside the scale of colours

constexpr double kShortest_m = 1e-3;  // the scale of colours is logarithmic

double ValueAtShare(std::vector<double> values, double share) {
  const auto at =
      values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

void AddDots(const PlacedDistances& distances, const std::vector<double>& apart_m, MapChart* map) {
  const std::size_t step = distances.east_m.size() / kMaxPlaces + 1;
  for (std::size_t k = 0; k < distances.east_m.size(); k += step) {
    map->valued.x.push_back(distances.east_m[k]);
    map->valued.y.push_back(distances.north_m[k]);
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

void PlacedDistances::Add(double east, double north, double before, double after) {
  east_m.push_back(east);
  north_m.push_back(north);
  before_m.push_back(before);
  after_m.push_back(after);
}

std::vector<MapChart> DistanceMaps(const ResultFolder& folder, const std::string& title,
                                   const PlacedDistances& distances) {
  if (distances.east_m.empty()) return {};
  std::vector<MapChart> maps;
  const double low_m = std::max(kShortest_m, ValueAtShare(distances.after_m, 1.0 - kOfAll));
  const double high_m = std::max(ValueAtShare(distances.before_m, kOfAll), 2.0 * low_m);
  for (const auto& [when, apart_m] :
       {std::pair("before", &distances.before_m), {"after", &distances.after_m}}) {
    MapChart map = SwathMap(folder, title + ", " + when);
    map.valued.label = std::string("apart ") + when + " [m]";
    map.valued.low = low_m;
    map.valued.high = high_m;
    AddDots(distances, *apart_m, &map);
    maps.push_back(std::move(map));
  }
  return maps;
}

}  // namespace dn::page_internal
