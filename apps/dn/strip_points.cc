#include "strip_points.h"

#include <dn/error.h>
#include <dn/lidar/strip_io.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace dn::apps {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr std::size_t kPointsPerStrip = 100000;
constexpr std::size_t kEvery = 7;
constexpr std::size_t kPointsOfGuess = 50;
// Largest difference of the distance of a point from the path and the length of its laser vector,
// if both are of the same flight; a share of the length.
constexpr double kRangeTolerance = 0.2;
constexpr double kLongestRange_m = 8000.0;

/// Adds points from the beginning of a strip.
void AddPoints(const fs::path& file, StripPoints* sample) {
  const auto strip = OpenStrip(file);
  sample->has_vectors = sample->has_vectors && strip->has_vectors();
  if (!strip->crs().name.empty()) sample->crs = strip->crs().name;
  std::size_t points = 0;
  for (StripCloud cloud; points < kPointsPerStrip && strip->Next(&cloud); points += cloud.size()) {
    for (std::size_t k = 0; k < cloud.size(); k += kEvery) {
      sample->t_s.push_back(cloud.t_s.empty() ? std::nan("") : cloud.t_s[k]);
      sample->p_c.push_back(cloud.p_c[k]);
      if (strip->has_vectors()) sample->u_s.push_back(cloud.u_s[k]);
    }
  }
  sample->points += static_cast<double>(points);
}

/// Returns the point in m; nullopt if it is outside of the system.
std::optional<Vector3d> ToMap(const PointCrs& crs, const Vector3d& p_c) {
  try {
    return crs.ToMap(p_c);
  } catch (const InvalidInput&) {
    return std::nullopt;
  }
}

/// Returns whether points are where a scanner on the path can measure them.
bool LieAbout(const PlacedPoints& placed, bool have_vectors) {
  if (placed.points.size() < kPointsOfGuess / 2) return false;
  std::size_t agree = 0;
  for (const PointAndVector& point : placed.points) {
    const double range_m = point.q_b_m.norm(), length_m = point.u_s_m.norm();
    agree += have_vectors ? std::abs(range_m - length_m) < kRangeTolerance * length_m
                          : range_m < kLongestRange_m && point.q_b_m.z() > 0.0;
  }
  return 10 * agree > 9 * placed.points.size();
}

}  // namespace

StripPoints TakeStripPoints(const std::vector<fs::path>& strips) {
  StripPoints sample;
  for (const fs::path& file : strips) {
    StripPoints whole = sample;
    try {
      AddPoints(file, &whole);
      sample = std::move(whole);
    } catch (const InvalidInput&) {
      continue;
    }
  }
  if (!sample.has_vectors) sample.u_s.clear();
  return sample;
}

PlacedPoints PlaceAbout(const RoughPath& path, const PointCrs& crs, const StripPoints& sample,
                        std::size_t step) {
  PlacedPoints placed;
  for (std::size_t k = 0; k < sample.p_c.size(); k += step) {
    const std::optional<MapPose> pose = path.At(sample.t_s[k]);
    const std::optional<Vector3d> p_m = ToMap(crs, sample.p_c[k]);
    if (!pose || !p_m) continue;
    placed.p_m.push_back(*p_m);
    PointAndVector point;
    point.q_b_m = pose->q_mb.conjugate() * (placed.p_m.back() - pose->p_mb);
    if (!sample.u_s.empty()) point.u_s_m = sample.u_s[k];
    placed.points.push_back(point);
  }
  return placed;
}

std::optional<PointCrs> FindPointCrs(const RoughPath& path, const StripPoints& sample,
                                     std::vector<std::string> guesses) {
  if (!sample.crs.empty()) guesses = {sample.crs};
  const std::size_t step = std::max<std::size_t>(1, sample.p_c.size() / kPointsOfGuess);
  for (const std::string& name : guesses) {
    try {
      PointCrs crs(name, path.frame);
      if (LieAbout(PlaceAbout(path, crs, sample, step), !sample.u_s.empty())) return crs;
    } catch (const InvalidInput&) {  // the system does not exist, or needs a grid
      continue;
    }
  }
  return std::nullopt;
}

}  // namespace dn::apps
