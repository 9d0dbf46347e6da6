#include <dn/adjustment/map_layers.h>
#include <dn/report/json.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kMostPairs = 20'000;

/// Converts positions of the mapping frame to coordinates of GeoJSON. Longitudes are within half a
/// turn of the origin's.
class LayerPosition {
 public:
  explicit LayerPosition(const LocalFrame& frame) : frame_(frame) {}

  Json operator()(const Vector3d& p_m) const {
    const Geodetic place = frame_.ToGeodetic(p_m);
    const double turn_rad =
        std::remainder(place.lon_rad - frame_.origin().lon_rad, 2.0 * std::numbers::pi);
    const double lon_rad = frame_.origin().lon_rad + turn_rad;
    return {Rounded(lon_rad * kDegPerRad, 1e9), Rounded(place.lat_rad * kDegPerRad, 1e9),
            Rounded(place.h_m, 1e3)};
  }

 private:
  static double Rounded(double value, double per_unit) {
    return std::round(value * per_unit) / per_unit;
  }

  const LocalFrame& frame_;
};

Json Feature(const char* kind, Json coordinates, Json properties) {
  return {{"type", "Feature"},
          {"geometry", {{"type", kind}, {"coordinates", std::move(coordinates)}}},
          {"properties", std::move(properties)}};
}

std::string FormatLayer(const char* name, Json features) {
  const Json layer{
      {"type", "FeatureCollection"}, {"name", name}, {"features", std::move(features)}};
  return layer.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

Json PathFeature(const Swath& swath, const LayerPosition& at) {
  Json line = Json::array();
  for (const Vector3d& p_m : swath.line_m) line.push_back(at(p_m));
  return Feature("LineString", line, {{"strip", swath.strip}, {"shows", "path"}});
}

/// Returns twice the area that the outline encloses, positive if it runs counterclockwise.
double DoubleArea(const std::vector<Eigen::Vector2d>& outline_en_m) {
  double area_m2 = 0.0;
  for (std::size_t k = 0; k < outline_en_m.size(); ++k) {
    const Eigen::Vector2d& a = outline_en_m[k];
    const Eigen::Vector2d& b = outline_en_m[(k + 1) % outline_en_m.size()];
    area_m2 += a.x() * b.y() - a.y() * b.x();
  }
  return area_m2;
}

/// The ring of a polygon runs counterclockwise and ends at its first corner.
Json AreaFeature(const Swath& swath, const LayerPosition& at) {
  std::vector<Eigen::Vector2d> corners = swath.outline_en_m;
  if (DoubleArea(corners) < 0.0) std::reverse(corners.begin(), corners.end());
  corners.push_back(corners.front());
  Json ring = Json::array();
  for (const Eigen::Vector2d& p : corners) {
    ring.push_back(at({p.x(), p.y(), swath.outline_up_m}));
  }
  return Feature("Polygon", Json::array({ring}), {{"strip", swath.strip}, {"shows", "swath"}});
}

Json ControlFeature(const ControlPointCheck& check, const Vector3d& p_m, const LayerPosition& at) {
  Json directions = Json::array();
  for (Eigen::Index k = 0; k < check.directions_enu.cols(); ++k) {
    directions.push_back(ToJson(check.directions_enu.col(k)));
  }
  return Feature("Point", at(p_m),
                 {{"name", check.name},
                  {"role", Word(check.role)},
                  {"directions_enu", directions},
                  {"residual_m", ToJson(check.residual_m)},
                  {"sigma_m", ToJson(check.covariance_m2.diagonal().cwiseSqrt())},
                  {"p_value", check.p_value}});
}

}  // namespace

std::string FormatSwathLayer(const std::vector<Swath>& swaths, const LocalFrame& frame) {
  const LayerPosition at(frame);
  Json features = Json::array();
  for (const Swath& swath : swaths) {
    if (swath.outline_en_m.size() > 2) features.push_back(AreaFeature(swath, at));
    if (swath.line_m.size() > 1) features.push_back(PathFeature(swath, at));
  }
  return FormatLayer("swaths", std::move(features));
}

std::string FormatPairLayer(const std::vector<PairResidual>& pairs, const LocalFrame& frame) {
  const LayerPosition at(frame);
  const std::size_t step = pairs.size() / (kMostPairs + 1) + 1;
  Json features = Json::array();
  for (std::size_t k = 0; k < pairs.size(); k += step) {
    const PairResidual& pair = pairs[k];
    features.push_back(Feature("Point", at(pair.ground_m),
                               {{"strips", pair.strips},
                                {"t_i_s", pair.i.t_s},
                                {"t_j_s", pair.j.t_s},
                                {"before_enu_m", ToJson(pair.before_enu_m)},
                                {"after_enu_m", ToJson(pair.after_enu_m)}}));
  }
  return FormatLayer("pairs", std::move(features));
}

std::string FormatControlLayer(const ControlCheck& check, const ControlData& control,
                               const LocalFrame& frame) {
  const LayerPosition at(frame);
  Json features = Json::array();
  for (const ControlPointCheck& point : check.points) {
    const auto surveyed = std::ranges::find(control.points, point.name, &ControlPoint::name);
    if (surveyed == control.points.end()) continue;
    features.push_back(ControlFeature(point, surveyed->p_m, at));
  }
  return FormatLayer("control", std::move(features));
}

}  // namespace dn
