#include "pair_simulation.h"

#include <dn/error.h>
#include <dn/sim/no_overlap.h>
#include <dn/sim/random.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>

#include "beams.h"
#include "scanner.h"
#include "smooth_field.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kLeastBetween_s = 0.5;  // between the epochs of a pair of one strip
constexpr int kTrials = 400;             // to estimate the size of an overlap
// Allows for a swath widened by roll.
constexpr double kExtraAngle_rad = 4.0 * std::numbers::pi / 180.0;
constexpr double kWidestAngle_rad = 85.0 * std::numbers::pi / 180.0;

/// Ground area that a strip can cover: a rectangle along its track.
class Footprint {
 public:
  Footprint(const Vector3d& begin_m, const Vector3d& end_m, double half_width_m)
      : begin_en_m_(begin_m.head<2>()),
        length_m_((end_m - begin_m).head<2>().norm()),
        along_((end_m - begin_m).head<2>() / length_m_),
        half_width_m_(half_width_m) {}

  double area_m2() const { return 2.0 * length_m_ * half_width_m_; }

  bool Contains(const Vector2d& en_m) const {
    const Vector2d d = en_m - begin_en_m_;
    const double x = d.dot(along_);
    const double y = along_.x() * d.y() - along_.y() * d.x();
    return x >= 0.0 && x <= length_m_ && std::abs(y) <= half_width_m_;
  }

  Vector2d Draw(Random& random) const {
    const double x = random.Uniform(0.0, length_m_);
    const double y = random.Uniform(-half_width_m_, half_width_m_);
    return begin_en_m_ + x * along_ + y * Vector2d(-along_.y(), along_.x());
  }

 private:
  Vector2d begin_en_m_;
  double length_m_;
  Vector2d along_;
  double half_width_m_;
};

struct Strip {
  StripInterval interval;
  MapPose first, last;
  Footprint footprint;
};

/// Two strips and the ground area that both can see.
struct Overlap {
  const Strip* i;
  const Strip* j;
  double seen_share = 0.0;  // fraction of the footprint of i
  long count = 0;
  std::string file = {};

  double area_m2() const { return seen_share * i->footprint.area_m2(); }
  std::string Strips() const { return i->interval.name + "_" + j->interval.name; }
};

struct TwoSightings {
  Sighting i, j;
  Vector2d en_m;  // the ground point that both see
};

class PairSampler {
 public:
  /// `scanner_i` and `scanner_j` measure the two ends; they may be the same.
  PairSampler(const Scanner& scanner_i, const Scanner& scanner_j, const Terrain& terrain)
      : scanner_i_(scanner_i), scanner_j_(scanner_j), terrain_(terrain) {}

  /// Draws a random ground point of the overlap and returns both sightings; nullopt if the draw
  /// fails.
  std::optional<TwoSightings> Try(const Overlap& overlap, Random& random) const {
    const Vector2d en_m = overlap.i->footprint.Draw(random);
    if (!overlap.j->footprint.Contains(en_m)) return std::nullopt;
    if (terrain_.Water(en_m)) return std::nullopt;
    const Vector3d point_m(en_m.x(), en_m.y(), terrain_.Surface(en_m));
    const auto from_i = See(scanner_i_, point_m, *overlap.i, random);
    if (!from_i) return std::nullopt;
    const auto from_j = See(scanner_j_, point_m, *overlap.j, random);
    if (!from_j || std::abs(from_i->t_s - from_j->t_s) < kLeastBetween_s) return std::nullopt;
    return TwoSightings{*from_i, *from_j, en_m};
  }

 private:
  static int DrawBeam(int beams, Random& random) {
    return std::min(beams - 1, static_cast<int>(random.Uniform() * beams));
  }

  /// Returns one sighting of the point from a strip, drawn at random if there are two. The beam of
  /// a rotating scanner is drawn first.
  static std::optional<Sighting> See(const Scanner& scanner, const Vector3d& point_m,
                                     const Strip& strip, Random& random) {
    const int beam = scanner.num_beams() == 0 ? kNoBeam : DrawBeam(scanner.num_beams(), random);
    const auto seen = scanner.See(point_m, strip.first, strip.last, beam);
    if (seen.empty()) return std::nullopt;
    return seen.size() == 2 && random.Uniform() < 0.5 ? seen[1] : seen[0];
  }

  const Scanner& scanner_i_;
  const Scanner& scanner_j_;
  const Terrain& terrain_;
};

std::vector<Strip> Footprints(const Scenario& scenario, const std::vector<StripInterval>& intervals,
                              const TruthTrajectory& truth, const Terrain& terrain) {
  const double angle = std::min(0.5 * scenario.lidar.fov_rad + kExtraAngle_rad, kWidestAngle_rad);
  std::vector<Strip> strips;
  for (const StripInterval& interval : intervals) {
    const MapPose first = truth.Pose(interval.t0_s), last = truth.Pose(interval.t1_s);
    const double above_m = std::max(first.p_mb.z(), last.p_mb.z()) - terrain.lowest_m();
    strips.push_back(
        {interval, first, last, Footprint(first.p_mb, last.p_mb, above_m * std::tan(angle))});
  }
  return strips;
}

/// Strips of the first and of the second ends of pairs.
struct StripLists {
  std::vector<Strip> i, j;
  /// The lists belong to two scanners, so that a strip may overlap with itself.
  bool two_scanners = false;
};

std::vector<Overlap> FindOverlaps(const StripLists& strips, const PairSampler& sampler,
                                  std::uint64_t seed, const std::string& folder) {
  std::vector<Overlap> overlaps;
  for (std::size_t i = 0; i < strips.i.size(); ++i) {
    for (std::size_t j = strips.two_scanners ? 0 : i + 1; j < strips.j.size(); ++j) {
      Overlap overlap{&strips.i[i], &strips.j[j]};
      overlap.file = folder + "/" + overlap.Strips() + ".txt";
      Random random(seed, "overlap " + overlap.file);
      int seen = 0;
      for (int trial = 0; trial < kTrials; ++trial) seen += sampler.Try(overlap, random) ? 1 : 0;
      overlap.seen_share = static_cast<double>(seen) / kTrials;
      if (seen > 0) overlaps.push_back(overlap);
    }
  }
  return overlaps;
}

/// Distributes `count` over the overlaps in proportion to area (largest remainder). Each overlap
/// gets at least one if there are enough.
void Allocate(std::vector<Overlap>& overlaps, long count) {
  double total_m2 = 0.0;
  for (const Overlap& overlap : overlaps) total_m2 += overlap.area_m2();
  const auto each = static_cast<long>(overlaps.size());
  const long base = count >= each ? 1 : 0;
  long left = count - base * each;
  const auto spread = static_cast<double>(left);
  std::vector<double> remainder;
  for (Overlap& overlap : overlaps) {
    const double share = spread * overlap.area_m2() / total_m2;
    const auto whole = static_cast<long>(share);
    overlap.count = base + whole;
    remainder.push_back(share - static_cast<double>(whole));
    left -= whole;
  }
  for (; left > 0; --left) {
    const auto largest = std::max_element(remainder.begin(), remainder.end());
    ++overlaps[static_cast<std::size_t>(largest - remainder.begin())].count;
    *largest = -1.0;
  }
}

std::vector<TwoSightings> Draw(const Overlap& overlap, const PairSampler& sampler,
                               std::uint64_t seed) {
  Random random(seed, "pairs " + overlap.file);
  std::vector<TwoSightings> drawn;
  while (static_cast<long>(drawn.size()) < overlap.count) {  // ends because some draws succeed
    if (const auto sightings = sampler.Try(overlap, random)) drawn.push_back(*sightings);
  }
  std::sort(drawn.begin(), drawn.end(),
            [](const TwoSightings& a, const TwoSightings& b) { return a.i.t_s < b.i.t_s; });
  return drawn;
}

/// Draws the pairs of one scanner or of two, with a given `span`.
class PairSimulator {
 public:
  PairSimulator(const PairSide& i, const PairSide& j, const std::vector<StripInterval>& intervals,
                const std::shared_ptr<const TruthTrajectory>& truth,
                const std::shared_ptr<const Terrain>& terrain, const PairSimulation& options)
      : i_(i),
        j_(j),
        strips_{Footprints(i.scenario, intervals, *truth, *terrain),
                Footprints(j.scenario, intervals, *truth, *terrain), &i.effects != &j.effects},
        truth_(truth),
        terrain_(terrain),
        options_(options) {}

  /// Returns pairs with true epochs and measured vectors.
  PairData Run(const LidarSpan& span) const {
    const Scanner scanner_i(i_.scenario.lidar, i_.effects, span, truth_, terrain_);
    const Scanner scanner_j(j_.scenario.lidar, j_.effects, span, truth_, terrain_);
    const PairSampler sampler(scanner_i, scanner_j, *terrain_);
    PairData data;
    for (const Overlap& overlap : SharedOut(sampler)) {
      if (overlap.count == 0) continue;
      Random random(options_.seed, "pair noise " + overlap.file);
      const std::optional<SmoothField> shared = SharedErrors(overlap);
      for (const TwoSightings& sightings : Draw(overlap, sampler, options_.seed)) {
        data.pairs.push_back(Measured(sightings, shared, random));
        data.pairs.back().file = static_cast<int>(data.files.size());
      }
      data.files.emplace_back(overlap.file);
      if (options_.progress) {
        options_.progress(static_cast<double>(data.pairs.size()) / static_cast<double>(Count()));
      }
    }
    return data;
  }

 private:
  long Count() const {
    return strips_.two_scanners ? i_.scenario.pairs.between : i_.scenario.pairs.count;
  }

  /// Returns the overlaps sorted by file name, with the number of pairs of each.
  std::vector<Overlap> SharedOut(const PairSampler& sampler) const {
    std::vector<Overlap> overlaps = FindOverlaps(strips_, sampler, options_.seed, options_.folder);
    if (overlaps.empty()) {
      throw NoOverlap("no two strips of scenario '" + i_.scenario.name +
                          "' overlap: move its lines closer together, or set pairs: {count: 0}",
                      i_.scenario.pairs.where);
    }
    Allocate(overlaps, Count());
    std::sort(overlaps.begin(), overlaps.end(),
              [](const Overlap& a, const Overlap& b) { return a.file < b.file; });
    return overlaps;
  }

  /// Returns the errors that neighbouring pairs of an overlap share, in sigmas; nullopt if there
  /// are none.
  std::optional<SmoothField> SharedErrors(const Overlap& overlap) const {
    if (i_.scenario.pairs.shared_fraction == 0.0) return std::nullopt;
    Random random(options_.seed, "shared errors " + overlap.file);
    return SmoothField(i_.scenario.pairs.shared_length_m, &random);
  }

  /// Returns the standard deviation per coordinate of the difference of a pair.
  double PairSigma(const TwoSightings& sightings) const {
    if (!options_.noise) return 0.0;
    const double mean_range_m = 0.5 * (sightings.i.u_s.norm() + sightings.j.u_s.norm());
    double sigma_p_m = i_.scenario.pairs.sigma_p_m;
    if (strips_.two_scanners) {
      sigma_p_m = std::hypot(sigma_p_m, j_.scenario.pairs.sigma_p_m) / std::numbers::sqrt2;
    }
    for (const auto& sigma_m : i_.effects.pair_sigma_m)
      sigma_p_m = sigma_m(sigma_p_m, mean_range_m);
    return sigma_p_m;
  }

  static Vector3d Measured(const Sighting& sighting, const PairSide& side) {
    Vector3d u_s = ReportedByBeam(side.scenario.lidar, sighting.beam, sighting.u_s);
    for (const auto& measured : side.effects.laser_vector) u_s = measured(u_s, sighting.t_s);
    return u_s;
  }

  LidarPair Measured(const TwoSightings& sightings, const std::optional<SmoothField>& shared,
                     Random& random) const {
    const double pair_sigma_m = PairSigma(sightings);
    const double fraction = i_.scenario.pairs.shared_fraction;
    const double sigma_m = std::sqrt(1.0 - fraction) * pair_sigma_m / std::numbers::sqrt2;
    LidarPair pair;
    pair.t_i_s = sightings.i.t_s;
    pair.t_j_s = sightings.j.t_s;
    pair.u_i_s = Measured(sightings.i, i_) + sigma_m * random.Normal3();
    pair.u_j_s = Measured(sightings.j, j_) + sigma_m * random.Normal3();
    pair.beam_i = sightings.i.beam;
    pair.beam_j = sightings.j.beam;
    if (shared) pair.u_i_s += std::sqrt(fraction) * pair_sigma_m * shared->At(sightings.en_m);
    return pair;
  }

  PairSide i_, j_;
  StripLists strips_;
  std::shared_ptr<const TruthTrajectory> truth_;
  std::shared_ptr<const Terrain> terrain_;
  const PairSimulation& options_;
};

/// Shifts the time tags and makes the errors of finished pairs, which are those of the first
/// scanner.
void Finish(const PairSide& i, const PairSide& j, PairData* data) {
  const LidarSpan span = LidarEpochSpan(data->pairs);
  const auto tag = [&](double t_s, const ActiveEffects& effects) {
    double later_s = 0.0;
    for (const auto& shift_s : effects.lidar_tag_shift_s) later_s += shift_s(t_s, span);
    return t_s + later_s;
  };
  for (LidarPair& pair : data->pairs) {
    pair.t_i_s = tag(pair.t_i_s, i.effects);
    pair.t_j_s = tag(pair.t_j_s, j.effects);
    for (const auto& spoil : i.effects.pairs) spoil(&pair);
  }
  for (const auto& spoil : i.effects.all_pairs) spoil(data);
}

/// Simulates pairs and makes the errors of their tags.
///
/// If a boresight varies, the epochs at which a point is seen depend slightly on the span of the
/// pairs. Since the span depends on these epochs in turn, the computation is iterated.
PairData SimulateSides(const PairSide& i, const PairSide& j,
                       const std::vector<StripInterval>& intervals,
                       const std::shared_ptr<const TruthTrajectory>& truth,
                       const std::shared_ptr<const Terrain>& terrain,
                       const PairSimulation& options) {
  constexpr int kMostRuns = 6;
  constexpr double kSameSpan_s = 1e-7;
  const PairSimulator simulator(i, j, intervals, truth, terrain, options);
  LidarSpan span = LidarEpochSpan(intervals);
  PairData data = simulator.Run(span);
  const bool varies = !i.effects.boresight_rad.empty() || !j.effects.boresight_rad.empty();
  for (int run = 1; run < kMostRuns && varies; ++run) {
    const LidarSpan drawn = LidarEpochSpan(data.pairs);
    if (std::abs(drawn.middle_s() - span.middle_s()) < kSameSpan_s) break;
    span = drawn;
    data = simulator.Run(span);
  }
  Finish(i, j, &data);
  return data;
}

}  // namespace

PairData SimulatePairs(const Scenario& scenario, const std::vector<StripInterval>& intervals,
                       const std::shared_ptr<const TruthTrajectory>& truth,
                       const std::shared_ptr<const Terrain>& terrain, const PairSimulation& options,
                       const ActiveEffects& effects) {
  const PairSide side{scenario, effects};
  return SimulateSides(side, side, intervals, truth, terrain, options);
}

PairData SimulatePairsBetween(const PairSide& i, const PairSide& j,
                              const std::vector<StripInterval>& strips,
                              const std::shared_ptr<const TruthTrajectory>& truth,
                              const std::shared_ptr<const Terrain>& terrain,
                              const PairSimulation& options) {
  return SimulateSides(i, j, strips, truth, terrain, options);
}

}  // namespace dn
