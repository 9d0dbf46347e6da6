#include "matcher.h"

#include <dn/error.h>
#include <dn/lidar/point_spacing.h>
#include <dn/parallel.h>
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <optional>
#include <utility>

#include "agree_with_neighbours.h"
#include "median_by_axis.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;

// Lengths in ground sampling distances.
constexpr double kSampleCell_gsd = 2.0;  // so small that a shifted raster has few holes
constexpr double kRasterCell_gsd = 3.0;
constexpr double kMargin_gsd = 6.0;     // of the points about a cell: reach, and error of the start
constexpr double kMostSigma_gsd = 0.5;  // three-dimensional sigma of a pair
constexpr double kLeastUp = 0.7071;     // of the normal of a surface: 45 deg from the vertical

constexpr int kShadowCells = 6;  // cells of 3 GSD: width of the ground hidden by a house
constexpr Pieces kCoarsePieces{16, 16, 300.0};
constexpr Pieces kFinePieces{8, 6, 1000.0};
constexpr int kRootCells = 32;   // side of the largest cells
constexpr int kPlaceCells = 16;  // distance between the places with a raster search
constexpr double kToleranceCells = 2.5;
constexpr double kShrink = 5.0;
constexpr int kMostLevels = 12;
// A boresight error tilts strips against each other, and the shifts within a cell then differ. The
// boresight of rasters is too coarse; that of a few cells is as good as the trajectory's attitude.
constexpr std::size_t kPilotRoots = 32;
constexpr double kSettledTurn_rad = 1e-4;
constexpr int kMostPasses = 2;
// A smaller ground sampling distance would leave a hundred empty cells or more for each point.
constexpr double kLeastShareOfSpacing = 0.1;
constexpr double kMostCells = 4e8;        // cells of a raster, 3 GB
constexpr double kMostPoints_gsd2 = 2.0;  // per square ground sampling distance
constexpr double kPointsAtOnce = 1.5e6;
constexpr std::size_t kNeighboursOfStart = 5;
constexpr std::size_t kFewestForFactor = 10;
constexpr std::size_t kPosesOfLine = 60;

double GsdFromDensity(const MatchSource& source, int threads) {
  constexpr double kCell_m = 1.0;
  const StripSample sample = SampleStrip(source, 0, kCell_m, threads, [](std::uint64_t) {});
  const auto spacing_m = PointSpacing(sample.p_m, static_cast<double>(sample.counts.kept));
  if (spacing_m) return *spacing_m;
  throw InvalidInput("the points are too sparse to be matched: fewer than 30 in a cell of 128 m",
                     {source.strips().front().files.front().string()});
}

struct Box {
  Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity());
  Vector2d high = Vector2d::Constant(-std::numeric_limits<double>::infinity());
};

Box BoundingBox(const StripSample& sample) {
  Box box;
  for (const Vector3d& p_m : sample.p_m) {
    box.low = box.low.cwiseMin(p_m.head<2>());
    box.high = box.high.cwiseMax(p_m.head<2>());
  }
  return box;
}

/// Returns a grid of the part of `a` that `b` may cover if `b` is shifted by up to margin_m.
/// Returns nullopt if there is no such part.
std::optional<RasterGrid> CommonGrid(const StripSample& a, const StripSample& b, double cell_m,
                                     double margin_m) {
  const Box box_a = BoundingBox(a), box_b = BoundingBox(b);
  const Vector2d margin = Vector2d::Constant(margin_m);
  const Vector2d low = box_a.low.cwiseMax(box_b.low - margin) - margin;
  const Vector2d high = box_a.high.cwiseMin(box_b.high + margin) + margin;
  const Vector2d inner = (high - margin) - (low + margin);
  if (!(inner.minCoeff() > 0.0)) return std::nullopt;
  const Vector2d across = (high - low) / cell_m;
  if (across.x() * across.y() > kMostCells) {
    throw InvalidInput(fmt::format(
        "two strips share an area of {:.1f} by {:.1f} km; remove stray points from them",
        1e-3 * (high - low).x(), 1e-3 * (high - low).y()));
  }
  RasterGrid grid;
  grid.cell_m = cell_m;
  grid.origin_en_m = (low / cell_m).array().floor() * cell_m;
  const Vector2i size = ((high - grid.origin_en_m) / cell_m).array().ceil().cast<int>();
  grid.nx = size.x();
  grid.ny = size.y();
  return grid;
}

/// Returns the surface of a pair whose shift is accurate in one direction only.
MatchedSurface AlongBestDirection(const MatchedPair& pair, const Eigen::Matrix3d& covariance_m2) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(covariance_m2);
  const Vector3d normal = eigen.eigenvectors().col(0);
  MatchedSurface surface;
  surface.pair.ends = pair.pair;
  surface.pair.normal_m = normal.z() < 0.0 ? Vector3d(-normal) : normal;
  surface.pair.sigma_m = std::sqrt(eigen.eigenvalues()[0]);
  surface.radius_m = pair.radius_m;
  return surface;
}

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

double Matcher::BaseCell() const { return kRasterCell_gsd * result_.gsd_m; }

const MatchResult& Matcher::BringTogether() {
  if (source_.strips().size() < 2 && MustOverlap()) {
    throw InvalidInput("correspondences need two strips or more, but there " +
                       std::string(source_.strips().size() == 1 ? "is one" : "are 0"));
  }
  result_.gsd_m = ChooseGsd();
  ReadSamples();
  double search_m = FirstSearch();
  for (int level = 0; level < kMostLevels && search_m > kFinePieces.search * BaseCell(); ++level) {
    search_m = RunLevel(search_m, kCoarsePieces);
  }
  if (HasBoresight()) RunLevel(kFinePieces.search * BaseCell(), kFinePieces);
  return result_;
}

MatchResult Matcher::Run() {
  BringTogether();
  for (int pilot = 0; HasBoresight() && pilot < MostPilots(); ++pilot) {
    const double turned_rad = MatchAll(kPilotRoots);
    PlaceSamples();
    if (turned_rad < kSettledTurn_rad) break;
  }
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  for (int pass = 1; MatchAll(kAll) > kSettledTurn_rad && pass < kMostPasses; ++pass) {
    PlaceSamples();
  }
  Finish();
  return std::move(result_);
}

void Matcher::Tell(const std::string& stage, const std::string& done) const {
  if (options_.progress) options_.progress(stage, done);
}

std::string Matcher::PairName(std::size_t i, std::size_t j) const {
  return source_.strips()[i].name + "-" + source_.strips()[j].name;
}

void Matcher::FailNoOverlap() const {
  throw InvalidInput(
      "no two strips overlap; check that they cover the same area and that "
      "strips_crs and the trajectory belong to the points",
      {source_.strips().front().files.front().string()});
}

double Matcher::ChooseGsd() const {
  Tell("density of strip " + source_.strips().front().name);
  const double spacing_m = GsdFromDensity(source_, options_.threads);
  const double gsd_m = options_.gsd_m.value_or(spacing_m);
  if (gsd_m >= kLeastShareOfSpacing * spacing_m) return std::sqrt(options_.beams) * gsd_m;
  throw InvalidConfig(
      fmt::format("the ground sampling distance is set to {:.3g} m, but strip {} has one point "
                  "per {:.2g} m by {:.2g} m; give at least {:.2g} m (--gsd, or lidar.gsd_m of "
                  "flight.yaml), or omit it",
                  gsd_m, source_.strips().front().name, spacing_m, spacing_m,
                  kLeastShareOfSpacing * spacing_m),
      {source_.strips().front().files.front().string()});
}

void Matcher::ReadSamples() {
  for (std::size_t s = 0; s < source_.strips().size(); ++s) {
    const std::string stage = "reading strip " + source_.strips()[s].name;
    Tell(stage);
    samples_.push_back(
        SampleStrip(source_, s, kSampleCell_gsd * result_.gsd_m, options_.threads,
                    [&](std::uint64_t points) { Tell(stage, fmt::format("{} points", points)); }));
    result_.strips.push_back(samples_.back().counts);
  }
}

double Matcher::ShiftByAngles() const {
  double sum_m = 0.0, count = 0.0;
  for (const StripSample& sample : samples_) {
    for (const Eigen::Vector3f& x : sample.x) sum_m += static_cast<double>(x.norm());
    count += static_cast<double>(sample.size());
  }
  return 2.5 * sum_m / count * std::tan(options_.search_rad);
}

void Matcher::PlaceSamples() {
  for (std::size_t s = 0; s < samples_.size(); ++s) {
    Place(source_, s, options_.threads, &samples_[s]);
  }
}

double Matcher::RunLevel(double search_m, const Pieces& pieces) {
  MatchLevel level;
  level.search_m = search_m;
  level.cell_m = std::max(BaseCell(), search_m / pieces.search);
  Tell(fmt::format("search within {:.1f} m", search_m));
  std::vector<CoarsePair> pairs;
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    for (std::size_t j = i + 1; j < samples_.size(); ++j) {
      if (Compares(i, j)) FindCoarse(i, j, pieces, &level, &pairs);
    }
  }
  const AlignmentFit fit = Align(pairs, kToleranceCells * level.cell_m);
  // Each place has several points.
  if (!pairs.empty()) level.agreeing = fit.agreeing * level.found / pairs.size();
  level.rms_m = fit.rms_m;
  level.boresight_rad = Boresight();
  PlaceSamples();
  result_.levels.push_back(level);
  return std::max(search_m / kShrink, 3.0 * fit.rms_m);
}

void Matcher::FindCoarse(std::size_t i, std::size_t j, const Pieces& pieces, MatchLevel* level,
                         std::vector<CoarsePair>* pairs) {
  const StripSample& a = samples_[i];
  const StripSample& b = samples_[j];
  const auto grid = CommonGrid(a, b, level->cell_m, level->search_m);
  if (!grid) return;
  const HeightRaster raster_a = MakeRaster(*grid, a.p_m, 0);
  const HeightRaster raster_b = MakeRaster(*grid, b.p_m, 0);
  const std::vector<Vector2i> centres = Centres(raster_a, pieces.places);
  level->places += centres.size();
  std::vector<std::optional<PieceShift>> shifts(centres.size());
  ParallelForChunks(
      centres.size(), 4, options_.threads, [&](std::size_t, std::size_t first, std::size_t past) {
        for (std::size_t k = first; k < past; ++k) {
          shifts[k] = FindShift(raster_a, raster_b, centres[k], pieces.half, pieces.search);
        }
      });
  for (std::size_t k = 0; k < centres.size(); ++k) {
    if (!shifts[k]) continue;
    ++level->found;
    if (!HasBoresight()) {
      AddCoarse(i, j, raster_a, raster_b, centres[k], shifts[k]->shift_m, pairs);
      continue;
    }
    // The corners of a piece carry its tilt, which shows roll and pitch.
    for (const Vector2i& sign :
         {Vector2i(-1, -1), Vector2i(1, -1), Vector2i(-1, 1), Vector2i(1, 1)}) {
      const Vector2i corner = pieces.half * sign;
      AddCoarse(i, j, raster_a, raster_b, centres[k] + corner, shifts[k]->At(corner), pairs);
    }
  }
}

std::vector<Vector2i> Matcher::Centres(const HeightRaster& raster, double places) {
  double filled = 0.0;
  for (const std::int32_t point : raster.point) filled += point >= 0 ? 1.0 : 0.0;
  const int step = std::max(4, static_cast<int>(std::sqrt(filled / places)));
  std::vector<Vector2i> centres;
  for (int y = step / 2; y < raster.grid.ny; y += step) {
    for (int x = step / 2; x < raster.grid.nx; x += step) {
      if (raster.point[raster.grid.Index(x, y)] >= 0) centres.emplace_back(x, y);
    }
  }
  return centres;
}

void Matcher::AddCoarse(std::size_t i, std::size_t j, const HeightRaster& raster_a,
                        const HeightRaster& raster_b, const Vector2i& place,
                        const Vector3d& shift_m, std::vector<CoarsePair>* pairs) const {
  const StripSample& a = samples_[i];
  const StripSample& b = samples_[j];
  if (!raster_a.grid.Has(place.x(), place.y())) return;
  const std::int32_t point = raster_a.point[raster_a.grid.Index(place.x(), place.y())];
  if (point < 0) return;
  const auto at = static_cast<std::size_t>(point);
  const Vector3d target_m = a.p_m[at] + shift_m;
  const Vector2i cell = raster_b.grid.CellIndex(target_m.head<2>());
  if (!raster_b.grid.Has(cell.x(), cell.y())) return;
  const std::int32_t nearest = raster_b.point[raster_b.grid.Index(cell.x(), cell.y())];
  if (nearest < 0) return;
  const auto to = static_cast<std::size_t>(nearest);
  pairs->push_back({i, j, a.t_s[at], b.t_s[to], source_.RawAt(i, a.t_s[at], b.p_m[to] - shift_m),
                    b.x[to].cast<double>(), -shift_m});
}

void Matcher::MatchStripPair(std::size_t i, std::size_t j, std::size_t most_roots) {
  const auto grid =
      CommonGrid(samples_[i], samples_[j], BaseCell(), kFinePieces.search * BaseCell());
  if (!grid) return;
  StripPairMatch match;
  match.i = i;
  match.j = j;
  const HeightRaster raster_a = MakeRaster(*grid, samples_[i].p_m, kShadowCells);
  const HeightRaster raster_b = MakeRaster(*grid, samples_[j].p_m, kShadowCells);
  for (std::size_t k = 0; k < grid->cells(); ++k) {
    if (!std::isnan(raster_a.z_m[k]) && !std::isnan(raster_b.z_m[k])) {
      match.overlap_m2 += grid->cell_m * grid->cell_m;
    }
  }
  if (match.overlap_m2 == 0.0) return;
  const std::vector<MatchedPlace> places = FindPlaces(raster_a, raster_b, &match);
  RegisteredCells work;
  if (!places.empty()) {
    std::vector<GroundCell> roots = ChooseCells(raster_a, raster_b, kRootCells);
    roots.resize(std::min(roots.size(), most_roots));
    work = RegisterRoots(match, roots, places);
  }
  registered_.push_back(std::move(work));
  result_.strip_pairs.push_back(std::move(match));
}

std::vector<MatchedPlace> Matcher::FindPlaces(const HeightRaster& a, const HeightRaster& b,
                                              StripPairMatch* match) const {
  Tell("places of " + PairName(match->i, match->j));
  const std::vector<GroundCell> cells = ChooseCells(a, b, kPlaceCells);
  std::vector<std::optional<PieceShift>> shifts(cells.size());
  ParallelForChunks(cells.size(), 4, options_.threads,
                    [&](std::size_t, std::size_t first, std::size_t past) {
                      for (std::size_t k = first; k < past; ++k) {
                        shifts[k] = FindShift(a, b, a.grid.CellIndex(cells[k].centre_en_m),
                                              kFinePieces.half, kFinePieces.search);
                      }
                    });
  std::vector<MatchedPlace> places;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    if (shifts[k]) places.push_back({cells[k].centre_en_m, shifts[k]->shift_m});
  }
  match->candidates = cells.size();
  match->found = places.size();
  return places;
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

Swath Matcher::MakeSwath(std::size_t strip) const {
  Swath swath{source_.strips()[strip].name, {}, {}};
  SwathOutline outline;
  const StripSample& sample = samples_[strip];
  for (std::size_t k = 0; k < sample.size(); ++k) outline.Add(sample.t_s[k], sample.p_m[k]);
  swath.outline_en_m = outline.Corners();
  swath.outline_up_m = outline.MeanUp();
  const StripCounts& counts = result_.strips[strip];
  for (const double t_s : EvenTimes(counts.t_begin_s, counts.t_end_s, kPosesOfLine)) {
    const std::optional<Vector3d> place_m = source_.BodyPosition(strip, t_s);
    if (place_m) swath.line_m.push_back(*place_m);
  }
  return swath;
}

double Matcher::MatchAll(std::size_t most_roots) {
  registered_.clear();
  result_.strip_pairs.clear();
  const Vector3d before_rad = Boresight();
  for (std::size_t i = 0; i < samples_.size(); ++i) {
    for (std::size_t j = i + 1; j < samples_.size(); ++j) {
      if (Compares(i, j)) MatchStripPair(i, j, most_roots);
    }
  }
  if (result_.strip_pairs.empty() && MustOverlap()) FailNoOverlap();
  result_.variance_factor = VarianceFactor();
  result_.surface_variance_factor = SurfaceVarianceFactor();
  for (std::size_t k = 0; k < registered_.size(); ++k) {
    TakeDetermined(k);
    TakeSurfaces(k);
  }
  AlignAll();
  for (StripPairMatch& match : result_.strip_pairs) KeepAgreeing(&match);
  AlignAll();
  for (StripPairMatch& match : result_.strip_pairs) KeepAgreeingSurfaces(&match);
  return (Boresight() - before_rad).norm();
}

void Matcher::Finish() {
  if (result_.pairs() > 0 && RemovePlantOffset(&result_)) AlignAll();
  for (std::size_t s = 0; s < samples_.size(); ++s) result_.swaths.push_back(MakeSwath(s));
  result_.boresight_rad = Boresight();
  PlacePairs();
}

void Matcher::TakeDetermined(std::size_t k) {
  StripPairMatch& match = result_.strip_pairs[k];
  const double most_m = kMostSigma_gsd * result_.gsd_m;
  for (RegisteredCell& w : registered_[k].cells) {
    const Eigen::Matrix3d covariance_m2 = w.registration.Covariance(result_.variance_factor);
    if (std::sqrt(covariance_m2.trace()) > most_m) {
      AddSurface(AlongBestDirection(w.pair, covariance_m2), &match);
      continue;
    }
    w.pair.pair.covariance_m2 = covariance_m2;
    match.pairs.push_back(w.pair);
  }
  match.registered = match.pairs.size();
}

void Matcher::TakeSurfaces(std::size_t k) {
  for (RegisteredSurface& w : registered_[k].surfaces) {
    w.surface.pair.sigma_m = std::sqrt(w.registration.Variance(result_.surface_variance_factor));
    AddSurface(w.surface, &result_.strip_pairs[k]);
  }
}

void Matcher::AddSurface(MatchedSurface surface, StripPairMatch* match) const {
  const double most_m = kMostSigma_gsd / std::sqrt(3.0) * result_.gsd_m;
  if (!TakesSurfaces() || surface.pair.normal_m.z() < kLeastUp || surface.pair.sigma_m > most_m)
    return;
  match->surfaces.push_back(std::move(surface));
}

void Matcher::KeepAgreeing(StripPairMatch* match) const {
  std::vector<PlacedShift> shifts;
  for (const MatchedPair& pair : match->pairs) {
    const Vector3d p_j_m = source_.Position(match->j, pair.pair.t_j_s, pair.pair.u_j_s);
    shifts.push_back({p_j_m.head<2>(), -Apart(*match, pair.pair), *pair.pair.covariance_m2});
  }
  const Agreement agreement = AgreeWithNeighbours(shifts);
  match->variance_factor = agreement.variance_factor;
  std::vector<MatchedPair> kept;
  for (std::size_t p = 0; p < shifts.size(); ++p) {
    if (!agreement.agrees[p]) continue;
    kept.push_back(match->pairs[p]);
    std::optional<Eigen::Matrix3d>& covariance_m2 = kept.back().pair.covariance_m2;
    covariance_m2 = agreement.Inflated(*covariance_m2);
  }
  match->pairs = std::move(kept);
}

void Matcher::KeepAgreeingSurfaces(StripPairMatch* match) const {
  std::vector<PlacedHeight> heights;
  for (const MatchedSurface& surface : match->surfaces) {
    const LidarPair& ends = surface.pair.ends;
    const Vector3d p_j_m = source_.Position(match->j, ends.t_j_s, ends.u_j_s);
    const double sigma_m = surface.pair.sigma_m;
    heights.push_back({p_j_m.head<2>(), -SurfacesApart(*match, surface), sigma_m * sigma_m});
  }
  const HeightAgreement agreement = AgreeInHeight(heights);
  match->surface_variance_factor = agreement.variance_factor;
  std::vector<MatchedSurface> kept;
  for (std::size_t k = 0; k < heights.size() && kept.size() < options_.most_pairs; ++k) {
    if (!agreement.agrees[k]) continue;
    kept.push_back(match->surfaces[k]);
    kept.back().pair.sigma_m *= std::sqrt(agreement.variance_factor);
  }
  match->surfaces = std::move(kept);
}

void Matcher::AlignAll() {
  std::vector<CoarsePair> pairs;
  for (const StripPairMatch& match : result_.strip_pairs) {
    for (const MatchedPair& pair : match.pairs) {
      pairs.push_back({match.i, match.j, pair.pair.t_i_s, pair.pair.t_j_s, pair.pair.u_i_s,
                       pair.pair.u_j_s, Apart(match, pair.pair)});
    }
  }
  Align(pairs, kToleranceCells * BaseCell());
}

void Matcher::PlacePairs() {
  for (StripPairMatch& match : result_.strip_pairs) {
    for (MatchedPair& pair : match.pairs) pair.after_m = Apart(match, pair.pair);
    for (MatchedSurface& surface : match.surfaces) {
      surface.after_m = SurfacesApart(match, surface);
    }
  }
  AsGiven([&] {
    for (StripPairMatch& match : result_.strip_pairs) {
      for (MatchedPair& pair : match.pairs) {
        pair.p_i_m = source_.Position(match.i, pair.pair.t_i_s, pair.pair.u_i_s);
        pair.p_j_m = source_.Position(match.j, pair.pair.t_j_s, pair.pair.u_j_s);
      }
      for (MatchedSurface& surface : match.surfaces) {
        const LidarPair& ends = surface.pair.ends;
        surface.p_j_m = source_.Position(match.j, ends.t_j_s, ends.u_j_s);
        surface.before_m = SurfacesApart(match, surface);
      }
    }
  });
}

Vector3d Matcher::Apart(const StripPairMatch& match, const LidarPair& pair) const {
  return source_.Position(match.i, pair.t_i_s, pair.u_i_s) -
         source_.Position(match.j, pair.t_j_s, pair.u_j_s);
}

double Matcher::SurfacesApart(const StripPairMatch& match, const MatchedSurface& surface) const {
  return surface.pair.normal_m.dot(Apart(match, surface.pair.ends));
}
}  // namespace dn::matching_internal
