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

#include "scanner.h"
#include "smooth_field.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kTrials = 400;  // to estimate the size of an overlap
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

  double area_m2() const { return seen_share * i->footprint.area_m2(); }
  std::string File() const { return "lidar/" + i->interval.name + "_" + j->interval.name + ".txt"; }
};

struct TwoSightings {
  Sighting i, j;
  Vector2d en_m;  // the ground point that both see
};

class PairSampler {
 public:
  PairSampler(const Scanner& scanner, const Terrain& terrain)
      : scanner_(scanner), terrain_(terrain) {}

  /// Draws a random ground point of the overlap and returns both sightings; nullopt if the draw
  /// fails.
  std::optional<TwoSightings> Try(const Overlap& overlap, Random& random) const {
    const Vector2d en_m = overlap.i->footprint.Draw(random);
    if (!overlap.j->footprint.Contains(en_m)) return std::nullopt;
    if (terrain_.Water(en_m)) return std::nullopt;
    const Vector3d point_m(en_m.x(), en_m.y(), terrain_.Surface(en_m));
    const auto from_i = See(point_m, *overlap.i, random);
    if (!from_i) return std::nullopt;
    const auto from_j = See(point_m, *overlap.j, random);
    if (!from_j) return std::nullopt;
    return TwoSightings{*from_i, *from_j, en_m};
  }

 private:
  /// Returns one sighting of the point from a strip, drawn at random if there are two.
  std::optional<Sighting> See(const Vector3d& point_m, const Strip& strip, Random& random) const {
    const auto seen = scanner_.See(point_m, strip.first, strip.last);
    if (seen.empty()) return std::nullopt;
    return seen.size() == 2 && random.Uniform() < 0.5 ? seen[1] : seen[0];
  }

  const Scanner& scanner_;
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

std::vector<Overlap> FindOverlaps(const std::vector<Strip>& strips, const PairSampler& sampler,
                                  std::uint64_t seed) {
  std::vector<Overlap> overlaps;
  for (std::size_t i = 0; i < strips.size(); ++i) {
    for (std::size_t j = i + 1; j < strips.size(); ++j) {
      Overlap overlap{&strips[i], &strips[j]};
      Random random(seed, "overlap " + overlap.File());
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
  Random random(seed, "pairs " + overlap.File());
  std::vector<TwoSightings> drawn;
  while (static_cast<long>(drawn.size()) < overlap.count) {  // ends because some draws succeed
    if (const auto sightings = sampler.Try(overlap, random)) drawn.push_back(*sightings);
  }
  std::sort(drawn.begin(), drawn.end(),
            [](const TwoSightings& a, const TwoSightings& b) { return a.i.t_s < b.i.t_s; });
  return drawn;
}

/// Draws the pairs of a flight for a scanner with a given `span`.
class PairSimulator {
 public:
  PairSimulator(const Scenario& scenario, const std::vector<StripInterval>& intervals,
                const std::shared_ptr<const TruthTrajectory>& truth,
                const std::shared_ptr<const Terrain>& terrain, const PairSimulation& options,
                const ActiveEffects& effects)
      : scenario_(scenario),
        strips_(Footprints(scenario, intervals, *truth, *terrain)),
        truth_(truth),
        terrain_(terrain),
        options_(options),
        effects_(effects) {}

  /// Returns pairs with true epochs and measured vectors.
  PairData Run(const LidarSpan& span) const {
    const Scanner scanner(scenario_.lidar, effects_, span, truth_, terrain_);
    const PairSampler sampler(scanner, *terrain_);
    PairData data;
    for (const Overlap& overlap : SharedOut(sampler)) {
      if (overlap.count == 0) continue;
      Random random(options_.seed, "pair noise " + overlap.File());
      const std::optional<SmoothField> shared = SharedErrors(overlap);
      for (const TwoSightings& sightings : Draw(overlap, sampler, options_.seed)) {
        data.pairs.push_back(Measured(sightings, shared, random));
        data.pairs.back().file = static_cast<int>(data.files.size());
      }
      data.files.emplace_back(overlap.File());
      if (options_.progress) {
        options_.progress(static_cast<double>(data.pairs.size()) /
                          static_cast<double>(scenario_.pairs.count));
      }
    }
    return data;
  }

 private:
  /// Returns the overlaps sorted by file name, with the number of pairs of each.
  std::vector<Overlap> SharedOut(const PairSampler& sampler) const {
    std::vector<Overlap> overlaps = FindOverlaps(strips_, sampler, options_.seed);
    if (overlaps.empty()) {
      throw NoOverlap("no two strips of scenario '" + scenario_.name +
                          "' overlap: move its lines closer together, or set pairs: {count: 0}",
                      scenario_.pairs.where);
    }
    Allocate(overlaps, scenario_.pairs.count);
    std::sort(overlaps.begin(), overlaps.end(),
              [](const Overlap& a, const Overlap& b) { return a.File() < b.File(); });
    return overlaps;
  }

  /// Returns the errors that neighbouring pairs of an overlap share, in sigmas; nullopt if there
  /// are none.
  std::optional<SmoothField> SharedErrors(const Overlap& overlap) const {
    if (scenario_.pairs.shared_fraction == 0.0) return std::nullopt;
    Random random(options_.seed, "shared errors " + overlap.File());
    return SmoothField(scenario_.pairs.shared_length_m, &random);
  }

  /// Returns the standard deviation per coordinate of the difference of a pair.
  double PairSigma(const TwoSightings& sightings) const {
    if (!options_.noise) return 0.0;
    const double mean_range_m = 0.5 * (sightings.i.u_s.norm() + sightings.j.u_s.norm());
    double sigma_p_m = scenario_.pairs.sigma_p_m;
    for (const auto& sigma_m : effects_.pair_sigma_m) sigma_p_m = sigma_m(sigma_p_m, mean_range_m);
    return sigma_p_m;
  }

  Vector3d Measured(const Sighting& sighting) const {
    Vector3d u_s = sighting.u_s;
    for (const auto& measured : effects_.laser_vector) u_s = measured(u_s, sighting.t_s);
    return u_s;
  }

  LidarPair Measured(const TwoSightings& sightings, const std::optional<SmoothField>& shared,
                     Random& random) const {
    const double pair_sigma_m = PairSigma(sightings);
    const double fraction = scenario_.pairs.shared_fraction;
    const double sigma_m = std::sqrt(1.0 - fraction) * pair_sigma_m / std::numbers::sqrt2;
    LidarPair pair;
    pair.t_i_s = sightings.i.t_s;
    pair.t_j_s = sightings.j.t_s;
    pair.u_i_s = Measured(sightings.i) + sigma_m * random.Normal3();
    pair.u_j_s = Measured(sightings.j) + sigma_m * random.Normal3();
    if (shared) pair.u_i_s += std::sqrt(fraction) * pair_sigma_m * shared->At(sightings.en_m);
    return pair;
  }

  const Scenario& scenario_;
  std::vector<Strip> strips_;
  std::shared_ptr<const TruthTrajectory> truth_;
  std::shared_ptr<const Terrain> terrain_;
  const PairSimulation& options_;
  const ActiveEffects& effects_;
};

void Finish(const ActiveEffects& effects, PairData* data) {
  const LidarSpan span = LidarEpochSpan(data->pairs);
  const auto tag = [&](double t_s) {
    double later_s = 0.0;
    for (const auto& shift_s : effects.lidar_tag_shift_s) later_s += shift_s(t_s, span);
    return t_s + later_s;
  };
  for (LidarPair& pair : data->pairs) {
    pair.t_i_s = tag(pair.t_i_s);
    pair.t_j_s = tag(pair.t_j_s);
    for (const auto& spoil : effects.pairs) spoil(&pair);
  }
  for (const auto& spoil : effects.all_pairs) spoil(data);
}

}  // namespace

PairData SimulatePairs(const Scenario& scenario, const std::vector<StripInterval>& intervals,
                       const std::shared_ptr<const TruthTrajectory>& truth,
                       const std::shared_ptr<const Terrain>& terrain, const PairSimulation& options,
                       const ActiveEffects& effects) {
  // If the boresight varies, the epochs at which a point is seen depend slightly on the span of the
  // pairs. Since the span depends on these epochs in turn, the computation is iterated.
  constexpr int kMostRuns = 6;
  constexpr double kSameSpan_s = 1e-7;
  const PairSimulator simulator(scenario, intervals, truth, terrain, options, effects);
  LidarSpan span = LidarEpochSpan(intervals);
  PairData data = simulator.Run(span);
  for (int run = 1; run < kMostRuns && !effects.boresight_rad.empty(); ++run) {
    const LidarSpan drawn = LidarEpochSpan(data.pairs);
    if (std::abs(drawn.middle_s() - span.middle_s()) < kSameSpan_s) break;
    span = drawn;
    data = simulator.Run(span);
  }
  Finish(effects, &data);
  return data;
}

}  // namespace dn
