#include "strip_sample.h"

#include <dn/lidar/strip_surface.h>

#include <cmath>
#include <unordered_map>

#include "place_points.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

struct CellHash {
  std::size_t operator()(std::uint64_t h) const {
    h ^= h >> 31;
    h *= 0x9e3779b97f4a7c15ULL;
    return static_cast<std::size_t>(h ^ (h >> 29));
  }
};

/// The point of a cell and its distance from the centre of the cell.
struct KeptPoint {
  std::uint32_t index;
  float squared_m2;
};

}  // namespace

void Place(const MatchSource& source, std::size_t strip, int threads, StripSample* sample) {
  PlacePoints(source, strip, sample->t_s, sample->x, threads, &sample->p_m);
}

StripSample SampleStrip(const MatchSource& source, std::size_t strip, double cell_m, int threads,
                        const std::function<void(std::uint64_t)>& told) {
  StripSample sample;
  std::unordered_map<std::uint64_t, KeptPoint, CellHash> cells;
  std::vector<Vector3d> p_m;
  std::uint64_t read = 0;
  sample.counts = source.Read(strip, [&](const RawPoints& points) {
    PlacePoints(source, strip, points.t_s, points.x, threads, &p_m);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vector2d cell = p_m[i].head<2>() / cell_m;
      const Vector2d corner = cell.array().floor();
      const auto off_m2 =
          static_cast<float>((cell - corner - Vector2d::Constant(0.5)).squaredNorm());
      const auto next = static_cast<std::uint32_t>(sample.size());
      const auto [at, is_new] =
          cells.try_emplace(CellKey(p_m[i].head<2>(), cell_m), KeptPoint{next, off_m2});
      if (is_new) {
        sample.t_s.push_back(points.t_s[i]);
        sample.x.emplace_back(points.x[i].cast<float>());
        sample.p_m.push_back(p_m[i]);
      } else if (off_m2 < at->second.squared_m2) {
        at->second.squared_m2 = off_m2;
        const std::size_t k = at->second.index;
        sample.t_s[k] = points.t_s[i];
        sample.x[k] = points.x[i].cast<float>();
        sample.p_m[k] = p_m[i];
      }
    }
    told(read += points.size());
  });
  sample.point_density_m2 = static_cast<double>(sample.counts.kept) /
                            (static_cast<double>(sample.size()) * cell_m * cell_m);
  return sample;
}

}  // namespace dn::matching_internal
