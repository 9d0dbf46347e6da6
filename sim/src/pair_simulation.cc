#include "pair_simulation.h"

#include <dn/error.h>
#include <dn/sim/random.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <string>

#include "pair_effects.h"
#include "scanner.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr int kTrials = 400;                                        // to measure an overlap
constexpr double kExtraAngle_rad = 4.0 * std::numbers::pi / 180.0;  // roll may widen the swath
constexpr double kWidestAngle_rad = 85.0 * std::numbers::pi / 180.0;

/// The ground that a strip may cover: a rectangle around its track.
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
  Footprint footprint;
};

/// Two strips, and how much ground both see.
struct Overlap {
  const Strip* i;
  const Strip* j;
  double seen_share = 0.0;  // of the footprint of i
  long count = 0;

  double area_m2() const { return seen_share * i->footprint.area_m2(); }
  std::string File() const { return "lidar/" + i->interval.name + "_" + j->interval.name + ".txt"; }
};

struct TwoSightings {
  Sighting i, j;
};

class PairSampler {
 public:
  PairSampler(const Scanner& scanner, const Terrain& terrain)
      : scanner_(scanner), terrain_(terrain) {}

  /// A random ground point of the overlap as seen from both strips; nothing when the draw missed.
  std::optional<TwoSightings> Try(const Overlap& overlap, Random& random) const {
    const Vector2d en_m = overlap.i->footprint.Draw(random);
    if (!overlap.j->footprint.Contains(en_m)) return std::nullopt;
    const Vector3d point_m(en_m.x(), en_m.y(), terrain_.Surface(en_m));
    const auto from_i = See(point_m, *overlap.i);
    if (!from_i) return std::nullopt;
    const auto from_j = See(point_m, *overlap.j);
    if (!from_j) return std::nullopt;
    return TwoSightings{*from_i, *from_j};
  }

 private:
  std::optional<Sighting> See(const Vector3d& point_m, const Strip& strip) const {
    return scanner_.See(point_m, strip.interval.t0_s, strip.interval.t1_s);
  }

  const Scanner& scanner_;
  const Terrain& terrain_;
};

std::vector<Strip> Footprints(const Scenario& scenario, const std::vector<StripInterval>& intervals,
                              const TruthTrajectory& truth, const Terrain& terrain) {
  const double angle = std::min(0.5 * scenario.lidar.fov_rad + kExtraAngle_rad, kWidestAngle_rad);
  std::vector<Strip> strips;
  for (const StripInterval& interval : intervals) {
    const Vector3d begin_m = truth.Pose(interval.t0_s).p_mb;
    const Vector3d end_m = truth.Pose(interval.t1_s).p_mb;
    const double above_m = std::max(begin_m.z(), end_m.z()) - terrain.lowest_m();
    strips.push_back({interval, Footprint(begin_m, end_m, above_m * std::tan(angle))});
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

/// Shares `count` out by area (largest remainder), at least one each where there are enough.
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
  while (static_cast<long>(drawn.size()) < overlap.count) {  // ends: a share of the draws succeeds
    if (const auto sightings = sampler.Try(overlap, random)) drawn.push_back(*sightings);
  }
  std::sort(drawn.begin(), drawn.end(),
            [](const TwoSightings& a, const TwoSightings& b) { return a.i.t_s < b.i.t_s; });
  return drawn;
}

}  // namespace

PairData SimulatePairs(const Scenario& scenario, const std::vector<StripInterval>& intervals,
                       const std::shared_ptr<const TruthTrajectory>& truth,
                       const std::shared_ptr<const Terrain>& terrain,
                       const PairSimulation& options) {
  const Scanner scanner(scenario.lidar, options.lever_arm_b_m, truth, terrain);
  const PairSampler sampler(scanner, *terrain);
  const std::vector<Strip> strips = Footprints(scenario, intervals, *truth, *terrain);
  std::vector<Overlap> overlaps = FindOverlaps(strips, sampler, options.seed);
  if (overlaps.empty()) {
    throw InvalidConfig(
        "no two strips of scenario '" + scenario.name +
            "' see the same ground: bring its lines closer, or set pairs: {count: 0}",
        scenario.pairs.where);
  }
  Allocate(overlaps, scenario.pairs.count);
  std::sort(overlaps.begin(), overlaps.end(),
            [](const Overlap& a, const Overlap& b) { return a.File() < b.File(); });

  const double end_sigma_m = options.noise ? scenario.pairs.sigma_p_m / std::numbers::sqrt2 : 0.0;
  PairData data;
  for (const Overlap& overlap : overlaps) {
    if (overlap.count == 0) continue;
    Random random(options.seed, "pair noise " + overlap.File());
    for (const TwoSightings& sightings : Draw(overlap, sampler, options.seed)) {
      LidarPair pair;
      pair.file = static_cast<int>(data.files.size());
      pair.t_i_s = sightings.i.t_s + options.time_offset_s;
      pair.t_j_s = sightings.j.t_s + options.time_offset_s;
      const double mean_range_m = 0.5 * (sightings.i.u_s.norm() + sightings.j.u_s.norm());
      const double sigma_m = end_sigma_m * PairNoiseRatio(scenario, mean_range_m);
      pair.u_i_s = Distort(scenario, sightings.i.u_s) + sigma_m * random.Normal3();
      pair.u_j_s = Distort(scenario, sightings.j.u_s) + sigma_m * random.Normal3();
      data.pairs.push_back(pair);
    }
    data.files.emplace_back(overlap.File());
    if (options.progress) {
      options.progress(static_cast<double>(data.pairs.size()) /
                       static_cast<double>(scenario.pairs.count));
    }
  }
  ApplyPairEffects(scenario, options.seed, options.noise, &data);
  return data;
}

}  // namespace dn
