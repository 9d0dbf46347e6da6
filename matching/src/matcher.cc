#include "matcher.h"

#include <dn/error.h>
#include <dn/lidar/point_spacing.h>
#include <dn/parallel.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

namespace dn::matching_internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;

// Lengths in ground sampling distances.
constexpr double kSampleCell_gsd = 2.0;  // so small that a shifted raster has few holes

constexpr int kShadowCells = 6;  // cells of 3 GSD: width of the ground hidden by a house
constexpr Pieces kCoarsePieces{16, 16, 300.0};
constexpr Pieces kFinePieces{8, 6, 1000.0};
constexpr int kPlaceCells = 16;  // distance between the places with a raster search
constexpr double kShrink = 5.0;
constexpr int kMostLevels = 12;
// A boresight error tilts strips against each other, and the shifts within a cell then differ. The
// boresight of rasters is too coarse; that of a few cells is as good as the trajectory's attitude.
constexpr std::size_t kPilotRoots = 32;
constexpr double kSettledTurn_rad = 1e-4;
constexpr int kMostPasses = 2;
// A smaller ground sampling distance would leave a hundred empty cells or more for each point.
constexpr double kLeastShareOfSpacing = 0.1;
constexpr double kMostCells = 4e8;  // cells of a raster, 3 GB
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

}  // namespace

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

}  // namespace dn::matching_internal
