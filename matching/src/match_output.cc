#include <dn/geo/text_table.h>
#include <dn/matching/match_output.h>
#include <dn/median.h>
#include <dn/quantile.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "strip_offsets.h"

namespace dn {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Json MisalignmentJson(const Misalignment& m) {
  return {{"mean_m", m.mean_m},
          {"rms_m", m.rms_m},
          {"median_m", m.median_m},
          {"p95_m", m.p95_m},
          {"max_m", m.max_m},
          {"mean_enu_m", ToJson(m.mean_enu_m)},
          {"heading_deg", m.heading_deg},
          {"same_direction", m.same_direction},
          {"separation", m.separation.ToJson()}};
}

Json LevelJson(const MatchLevel& level) {
  return {{"cell_m", level.cell_m},
          {"search_m", level.search_m},
          {"places", level.places},
          {"found", level.found},
          {"agreeing", level.agreeing},
          {"rms_m", level.rms_m},
          {"boresight_deg", ToJson(level.boresight_rad * kDegPerRad)}};
}

Json StripJson(const std::string& name, const StripCounts& counts) {
  const bool measured = counts.origin && counts.origin->kind == VectorOrigin::Kind::kMeasured;
  return {{"name", name},
          {"points", counts.points},
          {"kept", counts.kept},
          {"dropped", counts.dropped},
          {"laser_vectors", measured ? "file" : "computed"},
          {"laser_vectors_origin", counts.origin ? Json(Word(counts.origin->kind)) : Json()},
          {"t_begin_s", counts.t_begin_s},
          {"t_end_s", counts.t_end_s}};
}

struct Differences {
  std::vector<Vector3d> before_m, after_m;

  void Add(const StripPairMatch& match) {
    for (const MatchedPair& pair : match.pairs) {
      before_m.push_back(pair.before_m());
      after_m.push_back(pair.after_m);
    }
  }

  /// After the alignment, a single pair has no difference left.
  Json ToJson() const {
    if (before_m.empty()) return nullptr;
    return {
        {"before", MisalignmentJson(ComputeMisalignment(before_m))},
        {"after", after_m.size() < 2 ? Json() : MisalignmentJson(ComputeMisalignment(after_m))}};
  }
};

double MedianSigma(const StripPairMatch& match) {
  std::vector<double> sigmas;
  for (const MatchedPair& pair : match.pairs) {
    sigmas.push_back(std::sqrt(pair.pair.covariance_m2->trace()));
  }
  return Median(std::move(sigmas));
}

Json StripPairJson(const StripPairMatch& match, const MatchSource& source) {
  Differences differences;
  differences.Add(match);
  const std::string& a = source.strips()[match.i].name;
  const std::string& b = source.strips()[match.j].name;
  return {{"strips", {a, b}},
          {"overlap_m2", match.overlap_m2},
          {"counts",
           {{"candidates", match.candidates},
            {"found", match.found},
            {"registered", match.registered},
            {"pairs", match.pairs.size()},
            {"surface_pairs", match.surfaces.size()}}},
          {"variance_factor", match.variance_factor},
          {"surface_variance_factor", match.surface_variance_factor},
          {"evenness", ComputeEvenness(match.pairs, match.overlap_m2)},
          {"sigma_3d_median_m", match.pairs.empty() ? Json() : Json(MedianSigma(match))},
          {"misalignment", differences.ToJson()},
          {"offset", matching_internal::OffsetJson(match)}};
}

Json PlantOffsetJson(const PlantRangeOffset& plants) {
  return {{"offset_m", plants.offset_m}, {"sigma_m", plants.sigma_m}, {"share", plants.share}};
}

}  // namespace

Misalignment ComputeMisalignment(const std::vector<Vector3d>& differences_m) {
  Misalignment out;
  std::vector<double> norms;
  Vector2d directions = Vector2d::Zero();
  double squares = 0.0;
  for (const Vector3d& d_m : differences_m) {
    norms.push_back(d_m.norm());
    out.mean_m += norms.back();
    squares += d_m.squaredNorm();
    out.mean_enu_m += d_m;
    const double horizontal_m = d_m.head<2>().norm();
    if (horizontal_m > 0.0) directions += d_m.head<2>() / horizontal_m;
    out.separation.Add(d_m.z());
  }
  const auto n = static_cast<double>(differences_m.size());
  out.mean_m /= n;
  out.mean_enu_m /= n;
  out.rms_m = std::sqrt(squares / n);
  out.same_direction = directions.norm() / n;
  out.heading_deg = std::atan2(out.mean_enu_m.x(), out.mean_enu_m.y()) * kDegPerRad;
  out.median_m = Quantile(norms, 0.5);
  out.p95_m = Quantile(norms, 0.95);
  out.max_m = *std::max_element(norms.begin(), norms.end());
  return out;
}

double ComputeEvenness(const std::vector<MatchedPair>& pairs, double area_m2) {
  if (pairs.size() < 2 || !(area_m2 > 0.0)) return 0.0;
  double sum_m = 0.0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    double nearest_m2 = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < pairs.size(); ++k) {
      if (k == i) continue;
      nearest_m2 = std::min(nearest_m2, (pairs[k].p_j_m - pairs[i].p_j_m).head<2>().squaredNorm());
    }
    sum_m += std::sqrt(nearest_m2);
  }
  const auto n = static_cast<double>(pairs.size());
  return sum_m / n / (0.5 * std::sqrt(area_m2 / n));
}

Json MatchJson(const std::string& name, const MatchResult& result, const MatchSource& source) {
  Json strips = Json::array(), levels = Json::array(), strip_pairs = Json::array();
  for (std::size_t s = 0; s < result.strips.size(); ++s) {
    strips.push_back(StripJson(source.strips()[s].name, result.strips[s]));
  }
  for (const MatchLevel& level : result.levels) levels.push_back(LevelJson(level));
  Differences all;
  Json counts = {
      {"candidates", 0}, {"found", 0}, {"registered", 0}, {"pairs", 0}, {"surface_pairs", 0}};
  for (const StripPairMatch& match : result.strip_pairs) {
    strip_pairs.push_back(StripPairJson(match, source));
    all.Add(match);
    for (auto& [stage, count] : counts.items()) {
      count = count.get<std::size_t>() + strip_pairs.back()["counts"][stage].get<std::size_t>();
    }
  }
  Json json = {{"schema", "dn.match/1"},
               {"flight", name},
               {"gsd_m", result.gsd_m},
               {"boresight_used_deg", ToJson(result.boresight_rad * kDegPerRad)},
               {"variance_factor", result.variance_factor},
               {"surface_variance_factor", result.surface_variance_factor},
               {"counts", counts},
               {"misalignment", all.ToJson()},
               {"strips", strips},
               {"levels", levels},
               {"strip_pairs", strip_pairs},
               {"loops", matching_internal::LoopsJson(result, source)}};
  if (result.plant_offset) json["plant_offset"] = PlantOffsetJson(*result.plant_offset);
  return json;
}

std::string FormatMatches(const StripPairMatch& match) {
  std::string text =
      "# t_i [s], t_j [s], p_j east, north, up [m], p_i - p_j before east, north, up [m], after "
      "east, north, up [m], sigma east, north, up [m], radius [m]\n";
  for (const MatchedPair& pair : match.pairs) {
    text += FormatDouble(pair.pair.t_i_s) + ", " + FormatDouble(pair.pair.t_j_s);
    const Vector3d sigma_m = pair.pair.covariance_m2->diagonal().cwiseSqrt();
    for (const Vector3d& v : {pair.p_j_m, pair.before_m(), pair.after_m, sigma_m}) {
      for (int i = 0; i < 3; ++i) text += ", " + FormatDouble(std::round(v[i] * 1e5) / 1e5);
    }
    text += ", " + FormatDouble(pair.radius_m) + "\n";
  }
  return text;
}

std::string FormatSurfaceMatches(const StripPairMatch& match) {
  std::string text =
      "# t_i [s], t_j [s], p_j east, north, up [m], normal east, north, up, distance along the "
      "normal i - j before [m], after [m], sigma [m], radius [m]\n";
  for (const MatchedSurface& surface : match.surfaces) {
    text += FormatDouble(surface.pair.ends.t_i_s) + ", " + FormatDouble(surface.pair.ends.t_j_s);
    const auto append = [&](double value) {
      text += ", " + FormatDouble(std::round(value * 1e5) / 1e5);
    };
    for (const Vector3d& v : {surface.p_j_m, surface.pair.normal_m}) {
      for (int i = 0; i < 3; ++i) append(v[i]);
    }
    for (const double value : {surface.before_m, surface.after_m, surface.pair.sigma_m}) {
      append(value);
    }
    text += ", " + FormatDouble(surface.radius_m) + "\n";
  }
  return text;
}

}  // namespace dn
