#include <dn/files/flight_config.h>
#include <dn/files/surfaces.h>
#include <dn/lidar/surface_pairs.h>

#include <numbers>
#include <string>
#include <utility>

namespace dn {
namespace {

ControlPoint MakePlane(const SurfacePair& pair, const std::filesystem::path& file) {
  ControlPoint plane;
  plane.where = {file.string(), pair.ends.line, 0};
  plane.name = file.string() + ":" + std::to_string(pair.ends.line);
  plane.plane.emplace().normal_m = pair.normal_m;
  const double sigma_m = pair.sigma_m / std::numbers::sqrt2;
  plane.returns = {{pair.ends.t_i_s, pair.ends.u_i_s, {}, sigma_m, plane.where},
                   {pair.ends.t_j_s, pair.ends.u_j_s, {}, sigma_m, plane.where}};
  return plane;
}

}  // namespace

ControlData ReadSurfaces(const FlightConfig& config) {
  ControlData surfaces;
  if (!config.lidar || config.lidar->surface_pairs.empty()) return surfaces;
  SurfacePairData data =
      ReadSurfacePairs(config.folder, config.lidar->surface_pairs, config.lidar->time_offset_s);
  for (const SurfacePair& pair : data.pairs) {
    surfaces.points.push_back(
        MakePlane(pair, data.files[static_cast<std::size_t>(pair.ends.file)]));
  }
  surfaces.files = std::move(data.files);
  return surfaces;
}

}  // namespace dn
