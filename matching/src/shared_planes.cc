#include <dn/adjustment/trajectory_ends.h>
#include <dn/error.h>
#include <dn/matching/shared_planes.h>
#include <dn/rotation.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

namespace dn {
namespace {

using Eigen::Vector3d;
using Strips = std::vector<std::vector<PlacedPlane>>;
using Members = std::vector<long>;  // index of the plane in each strip; -1: not in this strip

constexpr int kExtractions = 2;
constexpr int kSearches = 3;  // after each extraction
constexpr double kLeastNoiseM = 0.005;
constexpr double kNearlyLevelRad = 5.0 * kRadPerDeg;
constexpr double kGentleRad = 15.0 * kRadPerDeg;
constexpr std::size_t kAspects = 8;
constexpr std::size_t kBins = 1 + 2 * kAspects;

Vector3d PointAt(const GaussHelmertEnd& end, const Vector3d& lever_arm_b_m,
                 const Eigen::Quaterniond& q_boresight) {
  return end.p_mb + end.q_mb * (q_boresight * end.u_b + lever_arm_b_m);
}

std::vector<PlanarRegion> Place(const std::vector<PlacedPlane>& planes,
                                const Vector3d& lever_arm_b_m, const Vector3d& theta_rad) {
  const Eigen::Quaterniond q_boresight = Exp(theta_rad);
  std::vector<PlanarRegion> regions;
  for (const PlacedPlane& plane : planes) {
    std::vector<Vector3d> points_m;
    for (const GaussHelmertEnd& end : plane.points) {
      points_m.push_back(PointAt(end, lever_arm_b_m, q_boresight));
    }
    regions.push_back(FitRegion(points_m));
  }
  return regions;
}

/// A grid of ground squares with the planes whose centroids lie in them.
class CentroidGrid {
 public:
  CentroidGrid(const std::vector<PlanarRegion>& regions, double side_m) : side_m_(side_m) {
    for (std::size_t k = 0; k < regions.size(); ++k) {
      cells_[CellIndex(regions[k].centroid_m, 0, 0)].push_back(k);
    }
  }

  /// Calls work(index) for all planes within one side length in east and north, and for some
  /// others.
  template <class Work>
  void ForNear(const Vector3d& p_m, const Work& work) const {
    for (long east = -1; east <= 1; ++east) {
      for (long north = -1; north <= 1; ++north) {
        const auto found = cells_.find(CellIndex(p_m, east, north));
        if (found == cells_.end()) continue;
        for (const std::size_t k : found->second) work(k);
      }
    }
  }

 private:
  std::pair<long, long> CellIndex(const Vector3d& p_m, long east, long north) const {
    return {std::lround(std::floor(p_m.x() / side_m_)) + east,
            std::lround(std::floor(p_m.y() / side_m_)) + north};
  }

  double side_m_;
  std::map<std::pair<long, long>, std::vector<std::size_t>> cells_;
};

struct Nearest {
  long index = -1;
  double distance_m = 0.0;
};

/// Returns, for each plane of `a`, the nearest plane of `b` that may be the same.
std::vector<Nearest> FindNearest(const std::vector<PlanarRegion>& a,
                                 const std::vector<PlanarRegion>& b, double search_m,
                                 double angle_rad) {
  double reach_m = search_m;
  for (const PlanarRegion& region : b) reach_m = std::max(reach_m, 0.5 * region.long_side_m);
  const CentroidGrid grid(b, std::max(reach_m, 1.0));
  std::vector<Nearest> nearest(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    grid.ForNear(a[i].centroid_m, [&](std::size_t j) {
      const double limit_m =
          search_m > 0.0 ? search_m : 0.5 * std::min(a[i].long_side_m, b[j].long_side_m);
      const double distance_m = (a[i].centroid_m - b[j].centroid_m).norm();
      if (distance_m > limit_m) return;
      if (a[i].normal.dot(b[j].normal) < std::cos(angle_rad)) return;
      if (nearest[i].index >= 0 && nearest[i].distance_m <= distance_m) return;
      nearest[i] = {static_cast<long>(j), distance_m};
    });
  }
  return nearest;
}

struct Match {
  double distance_m;
  std::size_t strip_a, a, strip_b, b;
};

std::vector<Match> MutualMatches(const std::vector<std::vector<PlanarRegion>>& strips,
                                 double search_m, double angle_rad) {
  std::vector<Match> matches;
  for (std::size_t s = 0; s < strips.size(); ++s) {
    for (std::size_t t = s + 1; t < strips.size(); ++t) {
      const auto there = FindNearest(strips[s], strips[t], search_m, angle_rad);
      const auto back = FindNearest(strips[t], strips[s], search_m, angle_rad);
      for (std::size_t i = 0; i < there.size(); ++i) {
        if (there[i].index < 0) continue;
        const auto j = static_cast<std::size_t>(there[i].index);
        if (back[j].index != static_cast<long>(i)) continue;
        matches.push_back({there[i].distance_m, s, i, t, j});
      }
    }
  }
  std::stable_sort(matches.begin(), matches.end(),
                   [](const Match& x, const Match& y) { return x.distance_m < y.distance_m; });
  return matches;
}

/// Groups of planes with at most one plane of each strip.
class Groups {
 public:
  explicit Groups(const Strips& strips) {
    for (const auto& planes : strips) group_of_.emplace_back(planes.size(), -1);
  }

  void Join(const Match& match) {
    long& a = group_of_[match.strip_a][match.a];
    long& b = group_of_[match.strip_b][match.b];
    if (a >= 0 && b >= 0) {
      Merge(a, b);
    } else if (a >= 0) {
      Put(a, match.strip_b, match.b);
    } else if (b >= 0) {
      Put(b, match.strip_a, match.a);
    } else {
      groups_.emplace_back(group_of_.size(), -1);
      Put(static_cast<long>(groups_.size()) - 1, match.strip_a, match.a);
      Put(static_cast<long>(groups_.size()) - 1, match.strip_b, match.b);
    }
  }

  std::vector<Members> groups() const {
    std::vector<Members> out;
    for (const Members& group : groups_) {
      if (std::any_of(group.begin(), group.end(), [](long k) { return k >= 0; })) {
        out.push_back(group);
      }
    }
    return out;
  }

 private:
  void Put(long group, std::size_t strip, std::size_t plane) {
    long& place = groups_[static_cast<std::size_t>(group)][strip];
    if (place >= 0) return;
    place = static_cast<long>(plane);
    group_of_[strip][plane] = group;
  }
  void Merge(long a, long b) {
    if (a == b) return;
    Members& into = groups_[static_cast<std::size_t>(a)];
    Members& from = groups_[static_cast<std::size_t>(b)];
    for (std::size_t s = 0; s < into.size(); ++s) {
      if (into[s] >= 0 && from[s] >= 0) return;
    }
    for (std::size_t s = 0; s < into.size(); ++s) {
      if (from[s] >= 0) Put(a, s, static_cast<std::size_t>(std::exchange(from[s], -1)));
    }
  }

  std::vector<std::vector<long>> group_of_;
  std::vector<Members> groups_;
};

ObservedPlane Join(const Strips& strips, const Members& members) {
  ObservedPlane plane;
  double sum_m2 = 0.0;
  for (std::size_t s = 0; s < members.size(); ++s) {
    if (members[s] < 0) continue;
    const PlacedPlane& part = strips[s][static_cast<std::size_t>(members[s])];
    sum_m2 += part.rms_m * part.rms_m * static_cast<double>(part.points.size());
    for (const GaussHelmertEnd& end : part.points) {
      plane.points.push_back({end, static_cast<int>(s)});
    }
  }
  const auto n = static_cast<double>(plane.points.size());
  plane.sigma_m = std::max(kLeastNoiseM, std::sqrt(sum_m2 / n));
  return plane;
}

/// Returns the bin of a normal: 0 if nearly level, else by aspect, gentle slopes first.
std::size_t NormalBin(const Vector3d& normal) {
  if (normal.z() > std::cos(kNearlyLevelRad)) return 0;
  const double turns = std::atan2(normal.y(), normal.x()) / (2.0 * std::numbers::pi) + 0.5;
  const auto aspect = static_cast<std::size_t>(static_cast<double>(kAspects) * turns) % kAspects;
  return 1 + aspect + (normal.z() > std::cos(kGentleRad) ? 0 : kAspects);
}

/// Keeps the largest planes of each bin.
std::vector<ObservedPlane> Balance(std::vector<ObservedPlane> planes, const Vector3d& lever_arm_b_m,
                                   const Vector3d& theta_rad, std::size_t most_of_bin) {
  struct Place {
    double area_m2;
    std::size_t index;
  };
  std::array<std::vector<Place>, kBins> bins;
  const Eigen::Quaterniond q_boresight = Exp(theta_rad);
  for (std::size_t q = 0; q < planes.size(); ++q) {
    std::vector<Vector3d> points_m;
    for (const PlanePoint& point : planes[q].points) {
      points_m.push_back(PointAt(point.end, lever_arm_b_m, q_boresight));
    }
    const PlanarRegion region = FitRegion(points_m);
    bins[NormalBin(region.normal)].push_back({region.short_side_m * region.long_side_m, q});
  }
  std::vector<std::size_t> kept;
  for (std::vector<Place>& bin : bins) {
    std::stable_sort(bin.begin(), bin.end(),
                     [](const Place& a, const Place& b) { return a.area_m2 > b.area_m2; });
    if (bin.size() > most_of_bin) bin.resize(most_of_bin);
    for (const Place& place : bin) kept.push_back(place.index);
  }
  std::sort(kept.begin(), kept.end());
  std::vector<ObservedPlane> out;
  for (const std::size_t q : kept) out.push_back(std::move(planes[q]));
  return out;
}

Strips OnTrajectory(const StripPlanes& planes, const TrajectoryEnds& ends, double* mean_range_m) {
  Strips strips;
  double sum_m = 0.0, n = 0.0;
  for (const std::vector<StripPlane>& of_strip : planes.strips) {
    std::vector<PlacedPlane>& placed = strips.emplace_back();
    for (const StripPlane& plane : of_strip) {
      PlacedPlane& part = placed.emplace_back();
      part.rms_m = plane.rms_m;
      for (std::size_t k = 0; k < plane.t_s.size(); ++k) {
        part.points.push_back(ends.At(plane.t_s[k], plane.u_s[k]));
        part.points.back().beam = plane.beam[k];
        sum_m += plane.u_s[k].norm();
        n += 1.0;
      }
    }
  }
  *mean_range_m = n > 0.0 ? sum_m / n : 0.0;
  return strips;
}

MatchOptions AlignmentOptions(const SharePlanesOptions& options) {
  MatchOptions align;
  align.gsd_m = options.strips.gsd_m;
  align.search_rad = options.search_rad;
  align.threads = options.strips.threads;
  if (options.strips.progress) {
    align.progress = [tell = options.strips.progress](const std::string& stage,
                                                      const std::string&) { tell(stage); };
  }
  return align;
}

/// Returns the boresight of the planes; nullopt if they do not determine it.
std::optional<Vector3d> Improve(const Flight& flight, const std::vector<ObservedPlane>& planes,
                                const Vector3d& theta_rad, int threads) {
  PlaneProblem problem = MakePlaneProblem(flight, planes);
  problem.boresight_rad = theta_rad;
  problem.with_range_offset = false;
  PlaneAdjustmentOptions options;
  options.threads = threads;
  options.point_sigmas = 0.0;
  try {
    const PlaneAdjustment adjustment = AdjustPlanes(problem, options);
    if (adjustment.converged) return adjustment.boresight_rad;
  } catch (const RankDeficient&) {
    return std::nullopt;
  }
  return std::nullopt;
}

}  // namespace

std::vector<Members> MatchPlanes(const Strips& strips, const Vector3d& lever_arm_b_m,
                                 const Vector3d& theta_rad, double search_m, double angle_rad) {
  std::vector<std::vector<PlanarRegion>> regions;
  for (const auto& planes : strips) regions.push_back(Place(planes, lever_arm_b_m, theta_rad));
  Groups groups(strips);
  for (const Match& match : MutualMatches(regions, search_m, angle_rad)) groups.Join(match);
  return groups.groups();
}

SharedPlanes FindSharedPlanes(const Flight& flight, FlightMatchSource* source,
                              const SharePlanesOptions& options) {
  const TrajectoryEnds ends(flight);
  const Vector3d& lever_arm_b_m = source->mounting().lever_arm_b_m;
  SharedPlanes out;
  out.levels = AlignFlight(source, AlignmentOptions(options));
  Vector3d theta_rad = source->mounting().boresight_rad;
  for (int extraction = 0; extraction < kExtractions; ++extraction) {
    const StripPlanes planes = ExtractStripPlanes(*source, options.strips);
    double range_m = 0.0;
    const Strips strips = OnTrajectory(planes, ends, &range_m);
    out.spacing_m = planes.spacing_m;
    out.share = planes.share;
    out.found.clear();
    for (const auto& of_strip : strips) out.found.push_back(of_strip.size());
    for (int search = 0; search < kSearches; ++search) {
      const bool first = extraction == 0 && search == 0;
      const double search_m = first ? 2.0 * options.misalignment_rad * range_m : 0.0;
      std::vector<ObservedPlane> seen;
      for (const Members& members :
           MatchPlanes(strips, lever_arm_b_m, theta_rad, search_m,
                       first ? options.first_angle_rad : options.angle_rad)) {
        seen.push_back(Join(strips, members));
      }
      out.matched = seen.size();
      out.planes = Balance(std::move(seen), lever_arm_b_m, theta_rad, options.most_of_bin);
      out.boresight_rad = theta_rad;
      const auto improved = Improve(flight, out.planes, theta_rad, options.strips.threads);
      if (!improved) return out;
      theta_rad = *improved;
    }
    source->SetBoresight(theta_rad);
  }
  return out;
}

}  // namespace dn
