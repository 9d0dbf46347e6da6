#include <dn/error.h>
#include <dn/lidar/beam.h>
#include <dn/matching/point_cloud.h>
#include <dn/matching/strip_planes.h>
#include <dn/median.h>
#include <dn/parallel.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "place_points.h"

namespace dn {
namespace {

using Eigen::Vector3d;

/// Indices of a ground square to the east and to the north.
using SquareKey = std::pair<long, long>;

// Every 32nd point is used to find the ground that a strip covers.
constexpr std::size_t kSampleStep = 32;
// Fraction of the typical density; lower values are the edge of a strip.
constexpr double kLeastOfTypical = 0.1;
constexpr double kGolden = 0.6180339887498949;  // distributes a fraction evenly over any sequence

SquareKey TileIndex(const Vector3d& p_m, double side_m) {
  return {std::lround(std::floor(p_m.x() / side_m)), std::lround(std::floor(p_m.y() / side_m))};
}

using Counts = std::map<SquareKey, double>;  // number of points

Counts CountPoints(const MatchSource& source, std::size_t strip, double side_m) {
  Counts counts;
  std::size_t read = 0;
  source.Read(strip, [&](const RawPoints& points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      if (read++ % kSampleStep != 0) continue;
      counts[TileIndex(source.Position(strip, points.t_s[i], points.x[i]), side_m)] += kSampleStep;
    }
  });
  return counts;
}

double Typical(const Counts& counts) {
  std::vector<double> values;
  for (const auto& [tile, n] : counts) values.push_back(n);
  return values.empty() ? 0.0 : Median(std::move(values));
}

/// The part of the ground that is searched for planes.
struct Selection {
  std::vector<SquareKey> tiles;  ///< sorted
  double density_m2 = 0.0;       ///< density of the sparsest strip
  double share = 1.0;
};

Selection Select(const MatchSource& source, const StripPlaneOptions& options) {
  std::map<SquareKey, int> covered;
  std::vector<Counts> counts;
  Selection selection;
  for (std::size_t s = 0; s < source.strips().size(); ++s) {
    if (options.progress) options.progress("cover of strip " + source.strips()[s].name);
    counts.push_back(CountPoints(source, s, options.tile_m));
    const double typical = Typical(counts.back());
    for (const auto& [tile, n] : counts.back()) {
      if (n >= kLeastOfTypical * typical) ++covered[tile];
    }
    const double density_m2 = typical / (options.tile_m * options.tile_m);
    selection.density_m2 = s == 0 ? density_m2 : std::min(selection.density_m2, density_m2);
  }
  std::erase_if(covered, [](const auto& tile) { return tile.second < 2; });
  if (covered.empty()) throw RankDeficient("no two strips overlap: there are no planes to compare");
  double most = 0.0;
  for (const Counts& of_strip : counts) {
    double sum = 0.0;
    for (const auto& [tile, n] : of_strip) sum += covered.contains(tile) ? n : 0.0;
    most = std::max(most, sum);
  }
  selection.share = std::min(1.0, static_cast<double>(options.most_points) / most);
  double at = 0.0;
  for (const auto& [tile, strips] : covered) {
    at += kGolden;
    if (at - std::floor(at) < selection.share) selection.tiles.push_back(tile);
  }
  return selection;
}

struct TilePoints {
  RawPoints raw;
  std::vector<int> beam;
  std::vector<Vector3d> p_m;
};

std::vector<TilePoints> ReadTiles(const MatchSource& source, std::size_t strip,
                                  const std::vector<SquareKey>& tiles,
                                  const StripPlaneOptions& options) {
  std::vector<TilePoints> out(tiles.size());
  std::vector<Vector3d> p_m;
  source.Read(strip, [&](const RawPoints& points) {
    matching_internal::PlacePoints(source, strip, points.t_s, points.x, options.threads, &p_m);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const SquareKey tile = TileIndex(p_m[i], options.tile_m);
      const auto found = std::lower_bound(tiles.begin(), tiles.end(), tile);
      if (found == tiles.end() || *found != tile) continue;
      TilePoints& of_tile = out[static_cast<std::size_t>(found - tiles.begin())];
      of_tile.raw.t_s.push_back(points.t_s[i]);
      of_tile.raw.x.push_back(points.x[i]);
      of_tile.beam.push_back(points.beam.empty() ? kNoBeam : points.beam[i]);
      of_tile.p_m.push_back(p_m[i]);
    }
  });
  return out;
}

StripPlane Take(const TilePoints& points, const std::vector<std::size_t>& thinned,
                const PlanarRegion& region, std::size_t most) {
  StripPlane plane;
  plane.rms_m = region.rms_m;
  const std::size_t n = std::min(most, region.points.size());
  for (std::size_t k = 0; k < n; ++k) {
    const std::size_t i = thinned[region.points[k * region.points.size() / n]];
    plane.t_s.push_back(points.raw.t_s[i]);
    plane.u_s.push_back(points.raw.x[i]);
    plane.beam.push_back(points.beam[i]);
  }
  return plane;
}

std::vector<StripPlane> GrowTilePlanes(const TilePoints& points, double spacing_m,
                                       std::size_t most) {
  const std::vector<std::size_t> thinned = ThinByVoxel(points.p_m, spacing_m);
  std::vector<Vector3d> p_m;
  p_m.reserve(thinned.size());
  for (const std::size_t i : thinned) p_m.push_back(points.p_m[i]);
  std::vector<StripPlane> planes;
  for (const PlanarRegion& region :
       GrowPlanarRegions(p_m, PlanarRegionOptions::ForSpacing(spacing_m))) {
    planes.push_back(Take(points, thinned, region, most));
  }
  return planes;
}

}  // namespace

StripPlanes ExtractStripPlanes(const MatchSource& source, const StripPlaneOptions& options) {
  const Selection selection = Select(source, options);
  StripPlanes out;
  out.share = selection.share;
  out.spacing_m = std::max(options.gsd_m.value_or(0.0), 1.0 / std::sqrt(selection.density_m2));
  for (std::size_t s = 0; s < source.strips().size(); ++s) {
    if (options.progress) options.progress("planes of strip " + source.strips()[s].name);
    const std::vector<TilePoints> tiles = ReadTiles(source, s, selection.tiles, options);
    std::vector<std::vector<StripPlane>> of_tiles(tiles.size());
    ParallelForChunks(
        tiles.size(), 1, options.threads, [&](std::size_t, std::size_t first, std::size_t past) {
          for (std::size_t k = first; k < past; ++k) {
            of_tiles[k] = GrowTilePlanes(tiles[k], out.spacing_m, options.most_points_of_plane);
          }
        });
    std::vector<StripPlane>& planes = out.strips.emplace_back();
    for (std::vector<StripPlane>& of_tile : of_tiles) {
      std::move(of_tile.begin(), of_tile.end(), std::back_inserter(planes));
    }
  }
  return out;
}

}  // namespace dn
