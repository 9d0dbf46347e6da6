#include <dn/error.h>
#include <dn/lidar/point_spacing.h>
#include <dn/matching/match.h>
#include <dn/parallel.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

#include "agree_with_neighbours.h"
#include "coarse_alignment.h"
#include "height_raster.h"
#include "match_cells.h"
#include "median_by_axis.h"
#include "patches.h"
#include "plant_offset.h"
#include "register_patches.h"
#include "strip_sample.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;
using matching_internal::AlignmentFit;
using matching_internal::CellPoints;
using matching_internal::CoarsePair;
using matching_internal::GatherCell;
using matching_internal::GroundCell;
using matching_internal::HeightRaster;
using matching_internal::kReach_gsd;
using matching_internal::MakeRaster;
using matching_internal::PlantOptions;
using matching_internal::PlantPair;
using matching_internal::RasterGrid;
using matching_internal::Registration;
using matching_internal::StripSample;

// Lengths in ground sampling distances.
constexpr double kSampleCell_gsd = 2.0;  // so small that a shifted raster has few holes
constexpr double kRasterCell_gsd = 3.0;
constexpr double kMargin_gsd = 6.0;     // of the points about a cell: reach, and error of the start
constexpr double kMostSigma_gsd = 0.5;  // three-dimensional sigma of a pair

constexpr int kCoarseHalf = 16;    // cells on each side of the centre of a coarse piece
constexpr int kCoarseSearch = 16;  // search radius in cells
constexpr int kShadowCells = 6;    // cells of 3 GSD: width of the ground hidden by a house
constexpr int kFineHalf = 8;
constexpr int kFineSearch = 6;
constexpr int kRootCells = 32;           // side of the largest cells
constexpr int kPlaceCells = 16;          // distance between the places with a raster search
constexpr double kCoarsePlaces = 300.0;  // approximate number per strip pair
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
constexpr double kPlantOffsetSigma_gsd = 0.5;  // prior; simulated forests have 0.3 to 0.4

/// A place with a unique shift between the rasters.
struct Place {
  Vector2d centre_en_m;
  Vector3d shift_m;  ///< of a to b
};

/// A registered cell of two strips and its pair.
struct Work {
  Registration registration;
  MatchedPair pair;
};

double GsdFromDensity(const MatchSource& source, int threads) {
  constexpr double kCell_m = 1.0;
  const StripSample sample =
      matching_internal::SampleStrip(source, 0, kCell_m, threads, [](std::uint64_t) {});
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

class Matcher {
 public:
  Matcher(MatchSource* source, const MatchOptions& options) : source_(*source), options_(options) {}
  virtual ~Matcher() = default;

  /// Runs the levels from coarse to fine; changes the alignment of the source.
  const MatchResult& BringTogether() {
    if (source_.strips().size() < 2) {
      throw InvalidInput("correspondences need two strips or more, but there " +
                         std::string(source_.strips().size() == 1 ? "is one" : "are 0"));
    }
    result_.gsd_m = ChooseGsd();
    ReadSamples();
    double search_m = FirstSearch();
    for (int level = 0; level < kMostLevels && search_m > kFineSearch * BaseCell(); ++level) {
      search_m = RunLevel(search_m);
    }
    return result_;
  }

  MatchResult Run() {
    BringTogether();
    if (HasBoresight()) {
      MatchAll(kPilotRoots);
      PlaceSamples();
    }
    constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
    for (int pass = 1; MatchAll(kAll) > kSettledTurn_rad && pass < kMostPasses; ++pass) {
      PlaceSamples();
    }
    Finish();
    return std::move(result_);
  }

 protected:
  /// Returns the radius of the coarsest search, m.
  virtual double FirstSearch() const = 0;
  virtual AlignmentFit Align(const std::vector<CoarsePair>& pairs, double tolerance_m) = 0;
  virtual bool HasBoresight() const { return false; }
  virtual Vector3d Boresight() const { return Vector3d::Zero(); }
  /// Corrects the pairs for the range offset of plants; returns whether it did.
  virtual bool RemovePlantOffset(MatchResult* /*result*/) const { return false; }
  /// Calls `work` with the initial alignment.
  virtual void AsGiven(const std::function<void()>& work) = 0;
  /// Returns whether two strips are matched with each other.
  virtual bool Compares(std::size_t /*i*/, std::size_t /*j*/) const { return true; }
  /// Returns whether strips without any overlap are an error.
  virtual bool MustOverlap() const { return true; }

  const std::vector<StripSample>& samples() const { return samples_; }
  const MatchOptions& options() const { return options_; }

 private:
  double BaseCell() const { return kRasterCell_gsd * result_.gsd_m; }

  void Tell(const std::string& stage, const std::string& done = "") const {
    if (options_.progress) options_.progress(stage, done);
  }

  std::string PairName(std::size_t i, std::size_t j) const {
    return source_.strips()[i].name + "-" + source_.strips()[j].name;
  }

  [[noreturn]] void FailNoOverlap() const {
    throw InvalidInput(
        "no two strips overlap; check that they cover the same area and that "
        "strips_crs and the trajectory belong to the points",
        {source_.strips().front().files.front().string()});
  }

  double ChooseGsd() const {
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

  void ReadSamples() {
    for (std::size_t s = 0; s < source_.strips().size(); ++s) {
      const std::string stage = "reading strip " + source_.strips()[s].name;
      Tell(stage);
      samples_.push_back(matching_internal::SampleStrip(
          source_, s, kSampleCell_gsd * result_.gsd_m, options_.threads,
          [&](std::uint64_t points) { Tell(stage, fmt::format("{} points", points)); }));
      result_.strips.push_back(samples_.back().counts);
    }
  }

  void PlaceSamples() {
    for (std::size_t s = 0; s < samples_.size(); ++s) {
      matching_internal::Place(source_, s, options_.threads, &samples_[s]);
    }
  }

  /// Runs one level of the alignment; returns the remaining search radius.
  double RunLevel(double search_m) {
    MatchLevel level;
    level.search_m = search_m;
    level.cell_m = std::max(BaseCell(), search_m / kCoarseSearch);
    Tell(fmt::format("search within {:.1f} m", search_m));
    std::vector<CoarsePair> pairs;
    for (std::size_t i = 0; i < samples_.size(); ++i) {
      for (std::size_t j = i + 1; j < samples_.size(); ++j) FindCoarse(i, j, &level, &pairs);
    }
    level.found = pairs.size();
    const AlignmentFit fit = Align(pairs, kToleranceCells * level.cell_m);
    level.agreeing = fit.agreeing;
    level.rms_m = fit.rms_m;
    level.boresight_rad = Boresight();
    PlaceSamples();
    result_.levels.push_back(level);
    return std::max(search_m / kShrink, 3.0 * fit.rms_m);
  }

  void FindCoarse(std::size_t i, std::size_t j, MatchLevel* level, std::vector<CoarsePair>* pairs) {
    const StripSample& a = samples_[i];
    const StripSample& b = samples_[j];
    const auto grid = CommonGrid(a, b, level->cell_m, level->search_m);
    if (!grid) return;
    const HeightRaster raster_a = MakeRaster(*grid, a.p_m, 0);
    const HeightRaster raster_b = MakeRaster(*grid, b.p_m, 0);
    const std::vector<Vector2i> centres = CoarseCentres(raster_a);
    level->places += centres.size();
    std::vector<std::optional<Vector3d>> shifts(centres.size());
    ParallelForChunks(centres.size(), 4, options_.threads,
                      [&](std::size_t, std::size_t first, std::size_t past) {
                        for (std::size_t k = first; k < past; ++k) {
                          shifts[k] = matching_internal::FindShift(raster_a, raster_b, centres[k],
                                                                   kCoarseHalf, kCoarseSearch);
                        }
                      });
    for (std::size_t k = 0; k < centres.size(); ++k) {
      if (shifts[k]) AddCoarse(i, j, raster_a, raster_b, centres[k], *shifts[k], pairs);
    }
  }

  static std::vector<Vector2i> CoarseCentres(const HeightRaster& raster) {
    double filled = 0.0;
    for (const std::int32_t point : raster.point) filled += point >= 0 ? 1.0 : 0.0;
    const int step = std::max(4, static_cast<int>(std::sqrt(filled / kCoarsePlaces)));
    std::vector<Vector2i> centres;
    for (int y = step / 2; y < raster.grid.ny; y += step) {
      for (int x = step / 2; x < raster.grid.nx; x += step) {
        if (raster.point[raster.grid.Index(x, y)] >= 0) centres.emplace_back(x, y);
      }
    }
    return centres;
  }

  void AddCoarse(std::size_t i, std::size_t j, const HeightRaster& raster_a,
                 const HeightRaster& raster_b, const Vector2i& centre, const Vector3d& shift_m,
                 std::vector<CoarsePair>* pairs) const {
    const StripSample& a = samples_[i];
    const StripSample& b = samples_[j];
    const auto at =
        static_cast<std::size_t>(raster_a.point[raster_a.grid.Index(centre.x(), centre.y())]);
    const Vector3d target_m = a.p_m[at] + shift_m;
    const Vector2i cell = raster_b.grid.CellIndex(target_m.head<2>());
    if (!raster_b.grid.Has(cell.x(), cell.y())) return;
    const std::int32_t nearest = raster_b.point[raster_b.grid.Index(cell.x(), cell.y())];
    if (nearest < 0) return;
    const auto to = static_cast<std::size_t>(nearest);
    pairs->push_back({i, j, a.t_s[at], b.t_s[to], source_.RawAt(i, a.t_s[at], b.p_m[to] - shift_m),
                      b.x[to].cast<double>(), -shift_m});
  }

  void MatchStripPair(std::size_t i, std::size_t j, std::size_t most_roots) {
    const auto grid = CommonGrid(samples_[i], samples_[j], BaseCell(), kFineSearch * BaseCell());
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
    const std::vector<Place> places = FindPlaces(raster_a, raster_b, &match);
    std::vector<Work> work;
    if (!places.empty()) {
      std::vector<GroundCell> roots =
          matching_internal::ChooseCells(raster_a, raster_b, kRootCells);
      roots.resize(std::min(roots.size(), most_roots));
      work = RegisterRoots(match, roots, places);
    }
    registered_.push_back(std::move(work));
    result_.strip_pairs.push_back(std::move(match));
  }

  /// Finds the shifts between the rasters at the places of a regular grid.
  std::vector<Place> FindPlaces(const HeightRaster& a, const HeightRaster& b,
                                StripPairMatch* match) const {
    Tell("places of " + PairName(match->i, match->j));
    const std::vector<GroundCell> cells = matching_internal::ChooseCells(a, b, kPlaceCells);
    std::vector<std::optional<Vector3d>> shifts(cells.size());
    ParallelForChunks(cells.size(), 4, options_.threads,
                      [&](std::size_t, std::size_t first, std::size_t past) {
                        for (std::size_t k = first; k < past; ++k) {
                          shifts[k] = matching_internal::FindShift(
                              a, b, a.grid.CellIndex(cells[k].centre_en_m), kFineHalf, kFineSearch);
                        }
                      });
    std::vector<Place> places;
    for (std::size_t k = 0; k < cells.size(); ++k) {
      if (shifts[k]) places.push_back({cells[k].centre_en_m, *shifts[k]});
    }
    match->candidates = cells.size();
    match->found = places.size();
    return places;
  }

  /// Returns the median shift of the places nearest to a cell.
  static Vector3d StartShift(const GroundCell& cell, const std::vector<Place>& places) {
    const auto off_m2 = [&](const Place& place) {
      return (place.centre_en_m - cell.centre_en_m).squaredNorm();
    };
    std::vector<Place> nearest(std::min(kNeighboursOfStart, places.size()));
    std::partial_sort_copy(places.begin(), places.end(), nearest.begin(), nearest.end(),
                           [&](const Place& p, const Place& q) { return off_m2(p) < off_m2(q); });
    std::vector<Vector3d> shifts_m;
    for (const Place& place : nearest) shifts_m.push_back(place.shift_m);
    return matching_internal::MedianByAxis(shifts_m);
  }

  /// Returns the largest number of points per square ground sampling distance, of all beams.
  double MostPoints() const { return kMostPoints_gsd2 * options_.beams; }

  double KeepShare(std::size_t strip) const {
    const double gsd_m = result_.gsd_m;
    return std::min(1.0, MostPoints() / (samples_[strip].point_density_m2 * gsd_m * gsd_m));
  }

  /// Registers the cells until there are enough pairs.
  std::vector<Work> RegisterRoots(const StripPairMatch& match, const std::vector<GroundCell>& roots,
                                  const std::vector<Place>& places) const {
    std::vector<Work> work;
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
      if (work.size() >= 2 * options_.most_pairs) break;
    }
    return work;
  }

  void RegisterSome(const StripPairMatch& match, const std::vector<GroundCell>& roots,
                    const std::vector<Place>& places, std::vector<Work>* work) const {
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
      return matching_internal::Gather(
          source_, strip, cells, options_.threads, [&](std::uint64_t points) {
            Tell("points of " + PairName(match.i, match.j),
                 fmt::format("{} points of strip {}", points, source_.strips()[strip].name));
          });
    };
    const std::vector<CellPoints> in_a = gather(match.i, cells_a), in_b = gather(match.j, cells_b);
    std::vector<std::vector<Work>> found(roots.size());
    ParallelForChunks(roots.size(), 1, options_.threads,
                      [&](std::size_t, std::size_t from, std::size_t to) {
                        for (std::size_t k = from; k < to; ++k) {
                          found[k] = RegisterRoot(match.i, roots[k], starts_m[k], in_a[k], in_b[k]);
                        }
                      });
    for (std::vector<Work>& each : found) std::ranges::move(each, std::back_inserter(*work));
  }

  std::vector<Work> RegisterRoot(std::size_t i, const GroundCell& root, const Vector3d& start_m,
                                 const CellPoints& in_a, const CellPoints& in_b) const {
    if (options_.beams > 1) return RegisterBeams(i, root, start_m, in_a, in_b);
    return RegisterPoints(i, root, start_m, in_a, in_b);
  }

  /// Registers every beam of the first strip with a beam of the second one. The difference of their
  /// numbers varies from cell to cell.
  std::vector<Work> RegisterBeams(std::size_t i, const GroundCell& root, const Vector3d& start_m,
                                  const CellPoints& in_a, const CellPoints& in_b) const {
    std::vector<Work> work;
    if (in_a.size() == 0 || in_b.size() == 0) return work;
    if (in_a.beam.empty() || in_b.beam.empty()) FailWithoutBeams();
    const double cells = root.centre_en_m.sum() / (2.0 * root.half_m);
    const int beams = options_.beams, apart = static_cast<int>(std::floor(cells)) % beams + beams;
    for (int beam = 0; beam < beams; ++beam) {
      const int other = (beam + apart) % beams;
      for (Work& each :
           RegisterPoints(i, root, start_m, in_a.WithBeam(beam), in_b.WithBeam(other))) {
        each.pair.pair.beam_i = beam;
        each.pair.pair.beam_j = other;
        work.push_back(std::move(each));
      }
    }
    return work;
  }

  [[noreturn]] void FailWithoutBeams() const {
    throw InvalidInput(
        "the points have no beam, but lidar.beams is given: add the column (text) or the extra "
        "bytes (LAS) `beam`, or leave out the key",
        {source_.strips().front().files.front().string()});
  }

  std::vector<Work> RegisterPoints(std::size_t i, const GroundCell& root, const Vector3d& start_m,
                                   const CellPoints& in_a, const CellPoints& in_b) const {
    std::vector<Work> work;
    if (in_a.size() == 0 || in_b.size() == 0) return work;
    const double gsd_m = result_.gsd_m;
    const matching_internal::PatchSurface a(in_a.p_m, kReach_gsd * gsd_m),
        b(in_b.p_m, kReach_gsd * gsd_m);
    const double smallest_m = options_.patch_gsd * gsd_m;
    for (const matching_internal::CellMatch& match :
         matching_internal::MatchCells(a, b, start_m, {root, gsd_m, smallest_m})) {
      work.push_back({match.registration, MakePair(i, match, in_a, in_b, b)});
    }
    return work;
  }

  /// Returns the pair nearest to the centre of the information of a cell.
  MatchedPair MakePair(std::size_t i, const matching_internal::CellMatch& match,
                       const CellPoints& in_a, const CellPoints& in_b,
                       const matching_internal::PatchSurface& b) const {
    std::size_t at = 0;
    const auto off_m2 = [&](std::size_t k) {
      return (in_a.p_m[k].head<2>() - match.registration.centre_en_m).squaredNorm();
    };
    for (std::size_t k = 1; k < in_a.size(); ++k) {
      if (off_m2(k) < off_m2(at)) at = k;
    }
    const Vector3d& shift_m = match.registration.shift_m;
    const std::size_t to = b.NearestTo(in_a.p_m[at] + shift_m).index;
    MatchedPair pair;
    pair.pair.t_i_s = in_a.t_s[at];
    pair.pair.t_j_s = in_b.t_s[to];
    pair.pair.u_i_s = source_.RawAt(i, in_a.t_s[at], in_b.p_m[to] - shift_m);
    pair.pair.u_j_s = in_b.x[to];
    pair.radius_m = match.cell.half_m;
    pair.volumetric_share = match.registration.volumetric_share;
    return pair;
  }

  /// Returns the mean of Registration::variance_ratio, at least 1.
  double VarianceFactor() const {
    std::vector<double> ratios;
    for (const auto& work : registered_) {
      for (const Work& w : work) {
        ratios.push_back(w.registration.variance_ratio);
      }
    }
    if (ratios.size() < kFewestForFactor) return 1.0;
    std::sort(ratios.begin(), ratios.end());
    const std::size_t cut = ratios.size() / 20;  // for the mean of the middle nine tenths
    double sum = 0.0;
    for (std::size_t k = cut; k < ratios.size() - cut; ++k) sum += ratios[k];
    return std::max(1.0, sum / static_cast<double>(ratios.size() - 2 * cut));
  }

  Swath MakeSwath(std::size_t strip) const {
    Swath swath{source_.strips()[strip].name, {}, {}};
    SwathOutline outline;
    const StripSample& sample = samples_[strip];
    for (std::size_t k = 0; k < sample.size(); ++k) outline.Add(sample.t_s[k], sample.p_m[k]);
    swath.outline_en_m = outline.Corners();
    swath.outline_up_m = outline.MeanUp();
    const StripCounts& counts = result_.strips[strip];
    for (const double t_s : EvenTimes(counts.t_begin_s, counts.t_end_s, kPosesOfLine)) {
      const std::optional<Vector3d> place_m = source_.BodyPosition(t_s);
      if (place_m) swath.line_m.push_back(*place_m);
    }
    return swath;
  }

  /// Matches all strips and aligns them by the pairs. Returns how far the boresight turned, rad.
  /// most_roots: number of largest cells of a strip pair.
  double MatchAll(std::size_t most_roots) {
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
    for (std::size_t k = 0; k < registered_.size(); ++k) TakeDetermined(k);
    AlignAll();
    for (StripPairMatch& match : result_.strip_pairs) KeepAgreeing(&match);
    AlignAll();
    return (Boresight() - before_rad).norm();
  }

  void Finish() {
    if (result_.pairs() > 0 && RemovePlantOffset(&result_)) AlignAll();
    for (std::size_t s = 0; s < samples_.size(); ++s) result_.swaths.push_back(MakeSwath(s));
    result_.boresight_rad = Boresight();
    PlacePairs();
  }

  /// Adds the pairs whose registration is accurate enough.
  void TakeDetermined(std::size_t k) {
    StripPairMatch& match = result_.strip_pairs[k];
    const double most_m = kMostSigma_gsd * result_.gsd_m;
    for (Work& w : registered_[k]) {
      const Eigen::Matrix3d covariance_m2 = w.registration.Covariance(result_.variance_factor);
      if (std::sqrt(covariance_m2.trace()) > most_m) continue;
      w.pair.pair.covariance_m2 = covariance_m2;
      match.pairs.push_back(w.pair);
    }
    match.registered = match.pairs.size();
  }

  /// Keeps the pairs that agree with their neighbours. The strips must be aligned first; otherwise
  /// the effect of the boresight, which varies with the position, would count as disagreement.
  void KeepAgreeing(StripPairMatch* match) const {
    std::vector<matching_internal::PlacedShift> shifts;
    for (const MatchedPair& pair : match->pairs) {
      const Vector3d p_j_m = source_.Position(match->j, pair.pair.t_j_s, pair.pair.u_j_s);
      shifts.push_back({p_j_m.head<2>(), -Apart(*match, pair), *pair.pair.covariance_m2});
    }
    const matching_internal::Agreement agreement = matching_internal::AgreeWithNeighbours(shifts);
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

  void AlignAll() {
    std::vector<CoarsePair> pairs;
    for (const StripPairMatch& match : result_.strip_pairs) {
      for (const MatchedPair& pair : match.pairs) {
        pairs.push_back({match.i, match.j, pair.pair.t_i_s, pair.pair.t_j_s, pair.pair.u_i_s,
                         pair.pair.u_j_s, Apart(match, pair)});
      }
    }
    Align(pairs, kToleranceCells * BaseCell());
  }

  /// Sets the positions and differences of the pairs before and after the alignment.
  void PlacePairs() {
    for (StripPairMatch& match : result_.strip_pairs) {
      for (MatchedPair& pair : match.pairs) pair.after_m = Apart(match, pair);
    }
    AsGiven([&] {
      for (StripPairMatch& match : result_.strip_pairs) {
        for (MatchedPair& pair : match.pairs) {
          pair.p_i_m = source_.Position(match.i, pair.pair.t_i_s, pair.pair.u_i_s);
          pair.p_j_m = source_.Position(match.j, pair.pair.t_j_s, pair.pair.u_j_s);
        }
      }
    });
  }

  Vector3d Apart(const StripPairMatch& match, const MatchedPair& pair) const {
    return source_.Position(match.i, pair.pair.t_i_s, pair.pair.u_i_s) -
           source_.Position(match.j, pair.pair.t_j_s, pair.pair.u_j_s);
  }

  MatchSource& source_;
  const MatchOptions& options_;
  std::vector<StripSample> samples_;
  std::vector<std::vector<Work>> registered_;  // one per entry of result_.strip_pairs
  MatchResult result_;
};

class FlightMatcher : public Matcher {
 public:
  FlightMatcher(FlightMatchSource* source, const MatchOptions& options)
      : Matcher(source, options), source_(*source), given_rad_(source->mounting().boresight_rad) {}

 private:
  /// Opposite strips move apart by twice the shift that the angle causes at the mean range. Half of
  /// this shift is added for the other angles.
  double FirstSearch() const override {
    double sum_m = 0.0, count = 0.0;
    for (const StripSample& sample : samples()) {
      for (const Eigen::Vector3f& x : sample.x) sum_m += static_cast<double>(x.norm());
      count += static_cast<double>(sample.size());
    }
    return 2.5 * sum_m / count * std::tan(options().search_rad);
  }

  AlignmentFit Align(const std::vector<CoarsePair>& pairs, double tolerance_m) override {
    return matching_internal::AlignBoresight(pairs, given_rad_, tolerance_m, options(), &source_);
  }

  bool HasBoresight() const override { return true; }
  Vector3d Boresight() const override { return source_.mounting().boresight_rad; }

  bool RemovePlantOffset(MatchResult* result) const override {
    const std::vector<std::vector<PlantPair>> pairs = MakePlantPairs(*result);
    std::vector<PlantPair> all;
    for (const std::vector<PlantPair>& each : pairs)
      all.insert(all.end(), each.begin(), each.end());
    const matching_internal::PlantOffset found = EstimatePlantOffset(all, PlantSettings(*result));
    double share = 0.0;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      for (std::size_t p = 0; p < pairs[k].size(); ++p) {
        Correct(result->strip_pairs[k].i, pairs[k][p], found, &result->strip_pairs[k].pairs[p]);
        share += pairs[k][p].volumetric_share.topLeftCorner<2, 2>().trace() / 2.0;
      }
    }
    result->plant_offset = {found.offset_m, found.sigma_m, share / static_cast<double>(all.size())};
    return true;
  }

  PlantOptions PlantSettings(const MatchResult& result) const {
    PlantOptions settings;
    settings.lever_arm_b_m = source_.mounting().lever_arm_b_m;
    settings.boresight_rad = source_.mounting().boresight_rad;
    settings.strip_position_sigma_m = options().sigma_ned_m.maxCoeff();
    settings.strip_attitude_sigma_rad = options().sigma_rph_rad.maxCoeff();
    settings.offset_sigma_m = kPlantOffsetSigma_gsd * result.gsd_m;
    settings.strips = source_.strips().size();
    return settings;
  }

  std::vector<std::vector<PlantPair>> MakePlantPairs(const MatchResult& result) const {
    const auto make_end = [&](double t_s, const Vector3d& u_s) {
      return matching_internal::MakeMatchEnd(source_, t_s, u_s, options());
    };
    std::vector<std::vector<PlantPair>> all;
    for (const StripPairMatch& match : result.strip_pairs) {
      all.emplace_back();
      for (const MatchedPair& pair : match.pairs) {
        const LidarPair& p = pair.pair;
        all.back().push_back(
            {{make_end(p.t_i_s, p.u_i_s), make_end(p.t_j_s, p.u_j_s), *p.covariance_m2},
             match.i,
             match.j,
             pair.volumetric_share,
             Beam(p.t_i_s, p.u_i_s),
             Beam(p.t_j_s, p.u_j_s)});
      }
    }
    return all;
  }

  Vector3d Beam(double t_s, const Vector3d& u_s) const {
    const Vector3d u_b = LaserVectorInBody(source_.mounting(), u_s);
    return source_.PoseAt(t_s).q_mb * u_b.normalized();
  }

  void Correct(std::size_t strip_i, const PlantPair& at,
               const matching_internal::PlantOffset& found, MatchedPair* pair) const {
    const Vector3d effect = at.Effect();
    LidarPair& p = pair->pair;
    const Vector3d p_i_m = source_.Position(strip_i, p.t_i_s, p.u_i_s);
    p.u_i_s = source_.RawAt(strip_i, p.t_i_s, p_i_m - found.offset_m * effect);
    *p.covariance_m2 += found.sigma_m * found.sigma_m * effect * effect.transpose();
  }

  void AsGiven(const std::function<void()>& work) override {
    const Vector3d found_rad = source_.mounting().boresight_rad;
    source_.SetBoresight(given_rad_);
    work();
    source_.SetBoresight(found_rad);
  }

  FlightMatchSource& source_;
  Vector3d given_rad_;
};

class BareMatcher : public Matcher {
 public:
  BareMatcher(BareMatchSource* source, const MatchOptions& options)
      : Matcher(source, options), source_(*source) {}

 private:
  double FirstSearch() const override { return options().search_m; }

  AlignmentFit Align(const std::vector<CoarsePair>& pairs, double tolerance_m) override {
    return matching_internal::AlignShifts(pairs, tolerance_m, &source_);
  }

  void AsGiven(const std::function<void()>& work) override {
    std::vector<Vector3d> found_m;
    for (std::size_t s = 0; s < source_.strips().size(); ++s) {
      found_m.push_back(source_.shift_m(s));
      source_.SetShift(s, Vector3d::Zero());
    }
    work();
    for (std::size_t s = 0; s < found_m.size(); ++s) source_.SetShift(s, found_m[s]);
  }

  BareMatchSource& source_;
};

/// The strips are together already, and stay as they are.
class ScannersMatcher : public Matcher {
 public:
  ScannersMatcher(ScannersMatchSource* source, const MatchOptions& options)
      : Matcher(source, options), source_(*source) {}

 private:
  double FirstSearch() const override { return 0.0; }

  AlignmentFit Align(const std::vector<CoarsePair>& pairs, double tolerance_m) override {
    AlignmentFit fit;
    double squares_m2 = 0.0;
    for (const CoarsePair& pair : pairs) {
      if (pair.difference_m.norm() > tolerance_m) continue;
      ++fit.agreeing;
      squares_m2 += pair.difference_m.squaredNorm();
    }
    if (fit.agreeing > 0) fit.rms_m = std::sqrt(squares_m2 / static_cast<double>(fit.agreeing));
    return fit;
  }

  void AsGiven(const std::function<void()>& work) override { work(); }

  bool Compares(std::size_t i, std::size_t j) const override {
    return source_.ScannerIndex(i) != source_.ScannerIndex(j);
  }

  bool MustOverlap() const override { return false; }

  const ScannersMatchSource& source_;
};

}  // namespace

std::size_t MatchResult::pairs() const {
  std::size_t count = 0;
  for (const StripPairMatch& match : strip_pairs) count += match.pairs.size();
  return count;
}

MatchResult MatchFlight(FlightMatchSource* source, const MatchOptions& options) {
  return FlightMatcher(source, options).Run();
}

std::vector<MatchLevel> AlignFlight(FlightMatchSource* source, const MatchOptions& options) {
  return FlightMatcher(source, options).BringTogether().levels;
}

MatchResult MatchBareStrips(BareMatchSource* source, const MatchOptions& options) {
  return BareMatcher(source, options).Run();
}

MatchResult MatchScanners(ScannersMatchSource* source, const MatchOptions& options) {
  return ScannersMatcher(source, options).Run();
}

}  // namespace dn
