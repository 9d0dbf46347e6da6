/// The part of Matcher that registers the cells of two strips.
#include <dn/error.h>
#include <dn/parallel.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "matcher.h"
#include "median_by_axis.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

// Lengths in ground sampling distances.
constexpr double kMargin_gsd = 6.0;  // of the points about a cell: reach, and error of the start
constexpr double kMostPoints_gsd2 = 2.0;  // per square ground sampling distance
constexpr double kPointsAtOnce = 1.5e6;
constexpr std::size_t kNeighboursOfStart = 5;
constexpr std::size_t kFewestForFactor = 10;

/// Returns the mean of the middle nine tenths of variance ratios, at least 1.
double MeanRatio(std::vector<double> ratios) {
  if (ratios.size() < kFewestForFactor) return 1.0;
  std::sort(ratios.begin(), ratios.end());
  const std::size_t cut = ratios.size() / 20;
  double sum = 0.0;
  for (std::size_t k = cut; k < ratios.size() - cut; ++k) sum += ratios[k];
  return std::max(1.0, sum / static_cast<double>(ratios.size() - 2 * cut));
}

}  // namespace

void RegisteredCells::Append(RegisteredCells more) {
  std::ranges::move(more.cells, std::back_inserter(cells));
  std::ranges::move(more.surfaces, std::back_inserter(surfaces));
}

Vector3d Matcher::StartShift(const GroundCell& cell, const std::vector<MatchedPlace>& places) {
  const auto off_m2 = [&](const MatchedPlace& place) {
    return (place.centre_en_m - cell.centre_en_m).squaredNorm();
  };
  std::vector<MatchedPlace> nearest(std::min(kNeighboursOfStart, places.size()));
  std::partial_sort_copy(
      places.begin(), places.end(), nearest.begin(), nearest.end(),
      [&](const MatchedPlace& p, const MatchedPlace& q) { return off_m2(p) < off_m2(q); });
  std::vector<Vector3d> shifts_m;
  for (const MatchedPlace& place : nearest) shifts_m.push_back(place.shift_m);
  return MedianByAxis(shifts_m);
}

double Matcher::MostPoints() const { return kMostPoints_gsd2 * options_.beams; }

double Matcher::KeepShare(std::size_t strip) const {
  const double gsd_m = result_.gsd_m;
  return std::min(1.0, MostPoints() / (samples_[strip].point_density_m2 * gsd_m * gsd_m));
}

RegisteredCells Matcher::RegisterRoots(const StripPairMatch& match,
                                       const std::vector<GroundCell>& roots,
                                       const std::vector<MatchedPlace>& places) const {
  RegisteredCells work;
  const double root_gsd = kRasterCell_gsd * kRootCells;
  const auto at_once = std::max<std::size_t>(
      1, static_cast<std::size_t>(kPointsAtOnce / (MostPoints() * root_gsd * root_gsd)));
  for (std::size_t first = 0; first < roots.size(); first += at_once) {
    const std::size_t past = std::min(roots.size(), first + at_once);
    RegisterSome(match,
                 {roots.begin() + static_cast<std::ptrdiff_t>(first),
                  roots.begin() + static_cast<std::ptrdiff_t>(past)},
                 places, &work);
    Tell("registration of " + PairName(match.i, match.j),
         fmt::format("{} of {}", past, roots.size()));
    if (work.cells.size() >= 2 * options_.most_pairs) break;
  }
  return work;
}

void Matcher::RegisterSome(const StripPairMatch& match, const std::vector<GroundCell>& roots,
                           const std::vector<MatchedPlace>& places, RegisteredCells* work) const {
  std::vector<Vector3d> starts_m;
  std::vector<GatherCell> cells_a, cells_b;
  const double margin_m = kMargin_gsd * result_.gsd_m;
  for (const GroundCell& root : roots) {
    starts_m.push_back(StartShift(root, places));
    cells_a.push_back({{root.centre_en_m, root.half_m + margin_m}, KeepShare(match.i)});
    cells_b.push_back({{root.centre_en_m + starts_m.back().head<2>(), root.half_m + margin_m},
                       KeepShare(match.j)});
  }
  const auto gather = [&](std::size_t strip, const std::vector<GatherCell>& cells) {
    return Gather(source_, strip, cells, options_.threads, [&](std::uint64_t points) {
      Tell("points of " + PairName(match.i, match.j),
           fmt::format("{} points of strip {}", points, source_.strips()[strip].name));
    });
  };
  const std::vector<CellPoints> in_a = gather(match.i, cells_a), in_b = gather(match.j, cells_b);
  std::vector<RegisteredCells> found(roots.size());
  ParallelForChunks(roots.size(), 1, options_.threads,
                    [&](std::size_t, std::size_t from, std::size_t to) {
                      for (std::size_t k = from; k < to; ++k) {
                        found[k] = RegisterRoot(match.i, roots[k], starts_m[k], in_a[k], in_b[k]);
                      }
                    });
  for (RegisteredCells& each : found) work->Append(std::move(each));
}

RegisteredCells Matcher::RegisterRoot(std::size_t i, const GroundCell& root,
                                      const Vector3d& start_m, const CellPoints& in_a,
                                      const CellPoints& in_b) const {
  if (options_.beams > 1) return RegisterBeams(i, root, start_m, in_a, in_b);
  return RegisterPoints(i, root, start_m, in_a, in_b);
}

RegisteredCells Matcher::RegisterBeams(std::size_t i, const GroundCell& root,
                                       const Vector3d& start_m, const CellPoints& in_a,
                                       const CellPoints& in_b) const {
  RegisteredCells work;
  if (in_a.size() == 0 || in_b.size() == 0) return work;
  if (in_a.beam.empty() || in_b.beam.empty()) FailWithoutBeams();
  const double cells = root.centre_en_m.sum() / (2.0 * root.half_m);
  const int beams = options_.beams, apart = static_cast<int>(std::floor(cells)) % beams + beams;
  for (int beam = 0; beam < beams; ++beam) {
    const int other = (beam + apart) % beams;
    RegisteredCells found =
        RegisterPoints(i, root, start_m, in_a.WithBeam(beam), in_b.WithBeam(other));
    for (RegisteredCell& each : found.cells) {
      each.pair.pair.beam_i = beam;
      each.pair.pair.beam_j = other;
    }
    work.Append(std::move(found));
  }
  return work;
}

void Matcher::FailWithoutBeams() const {
  throw InvalidInput(
      "the points have no beam, but lidar.beams is given: add the column (text) or the extra "
      "bytes (LAS) `beam`, or leave out the key",
      {source_.strips().front().files.front().string()});
}

RegisteredCells Matcher::RegisterPoints(std::size_t i, const GroundCell& root,
                                        const Vector3d& start_m, const CellPoints& in_a,
                                        const CellPoints& in_b) const {
  RegisteredCells work;
  if (in_a.size() == 0 || in_b.size() == 0) return work;
  const double gsd_m = result_.gsd_m;
  const PatchSurface a(in_a.p_m, kReach_gsd * gsd_m), b(in_b.p_m, kReach_gsd * gsd_m);
  const CellMatches matches =
      MatchCells(a, b, start_m, {root, gsd_m, options_.patch_gsd * gsd_m, TakesSurfaces()});
  for (const auto& [cell, registration] : matches.cells) {
    MatchedPair pair;
    pair.pair = MakePair(i, registration.centre_en_m, registration.shift_m, in_a, in_b, b);
    pair.radius_m = cell.half_m;
    pair.volumetric_share = registration.volumetric_share;
    work.cells.push_back({registration, std::move(pair)});
  }
  for (const auto& [cell, registration] : matches.surfaces) {
    MatchedSurface surface;
    surface.pair.ends = MakePair(i, registration.centre_en_m, registration.shift_m, in_a, in_b, b);
    surface.pair.normal_m = registration.normal_m;
    surface.radius_m = cell.half_m;
    work.surfaces.push_back({registration, std::move(surface)});
  }
  return work;
}

LidarPair Matcher::MakePair(std::size_t i, const Vector2d& at_en_m, const Vector3d& shift_m,
                            const CellPoints& in_a, const CellPoints& in_b,
                            const PatchSurface& b) const {
  std::size_t at = 0;
  const auto off_m2 = [&](std::size_t k) {
    return (in_a.p_m[k].head<2>() - at_en_m).squaredNorm();
  };
  for (std::size_t k = 1; k < in_a.size(); ++k) {
    if (off_m2(k) < off_m2(at)) at = k;
  }
  const std::size_t to = b.NearestTo(in_a.p_m[at] + shift_m).index;
  LidarPair pair;
  pair.t_i_s = in_a.t_s[at];
  pair.t_j_s = in_b.t_s[to];
  pair.u_i_s = source_.RawAt(i, in_a.t_s[at], in_b.p_m[to] - shift_m);
  pair.u_j_s = in_b.x[to];
  return pair;
}

double Matcher::VarianceFactor() const {
  std::vector<double> ratios;
  for (const RegisteredCells& work : registered_) {
    for (const RegisteredCell& w : work.cells) ratios.push_back(w.registration.variance_ratio);
  }
  return MeanRatio(std::move(ratios));
}

double Matcher::SurfaceVarianceFactor() const {
  std::vector<double> ratios;
  for (const RegisteredCells& work : registered_) {
    for (const RegisteredSurface& w : work.surfaces) {
      ratios.push_back(w.registration.variance_ratio);
    }
  }
  return MeanRatio(std::move(ratios));
}

}  // namespace dn::matching_internal
