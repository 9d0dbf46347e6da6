#include <dn/error.h>
#include <dn/lidar/strip_io.h>
#include <dn/matching/match_source.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace dn {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

constexpr const char* kNotLast = "not the last return of its pulse";

/// The points that are the strip's, each the last return of its pulse: what lies under trees is the
/// same ground from every side, crowns and edges of roofs are not.
template <class Points>
void Keep(const MatchStrip& wanted, const Points& points, const std::vector<Vector3d>& x,
          RawPoints* kept, StripCounts* counts) {
  kept->t_s.clear();
  kept->x.clear();
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (wanted.source && (points.source.empty() || points.source[i] != *wanted.source)) continue;
    if (!points.returns_after.empty() && points.returns_after[i] > 0) {
      ++counts->dropped[kNotLast];
      continue;
    }
    kept->t_s.push_back(points.t_s[i]);
    kept->x.push_back(x[i]);
  }
  counts->kept += kept->size();
}

/// Adds what was read of a file, but for the points kept.
void Join(const StripCounts& file, StripCounts* all) {
  const bool first = all->points == 0;
  all->own_vectors = file.own_vectors;
  all->t_begin_s = first ? file.t_begin_s : std::min(all->t_begin_s, file.t_begin_s);
  all->t_end_s = first ? file.t_end_s : std::max(all->t_end_s, file.t_end_s);
  all->points += file.points;
  for (const auto& [reason, count] : file.dropped) all->dropped[reason] += count;
}

}  // namespace

std::vector<MatchStrip> FindMatchStrips(const std::vector<fs::path>& files) {
  std::map<std::uint16_t, std::vector<fs::path>> by_source;
  bool tiles = false;
  for (const fs::path& file : files) {
    std::set<std::uint16_t> ids;
    const auto reader = OpenStrip(file);
    for (StripCloud points; reader->Next(&points) && !points.source.empty();) {
      ids.insert(points.source.begin(), points.source.end());
    }
    for (const std::uint16_t id : ids) by_source[id].push_back(file);
    tiles = tiles || ids.size() > 1;
  }
  std::vector<MatchStrip> strips;
  if (tiles) {
    for (const auto& [id, of_id] : by_source) strips.push_back({std::to_string(id), of_id, id});
  } else {
    for (const fs::path& file : files) strips.push_back({file.stem().string(), {file}});
  }
  return strips;
}

FlightMatchSource::FlightMatchSource(StripSourceOptions options, const LocalFrame& frame,
                                     const std::string& strips_crs, std::vector<MatchStrip> strips)
    : mounting_(options.made_with),
      frame_(frame),
      source_(std::move(options), frame, strips_crs),
      strips_(std::move(strips)) {}

StripCounts FlightMatchSource::Read(std::size_t strip,
                                    const std::function<void(const RawPoints&)>& take) const {
  const MatchStrip& wanted = strips_.at(strip);
  StripCounts counts;
  RawPoints points;
  for (const std::filesystem::path& file : wanted.files) {
    Join(source_.Read(file,
                      [&](const LaserVectors& vectors) {
                        Keep(wanted, vectors, vectors.u_s, &points, &counts);
                        if (points.size() > 0) take(points);
                      }),
         &counts);
  }
  return counts;
}

Vector3d FlightMatchSource::Position(std::size_t, double t_s, const Vector3d& x) const {
  return Georeference(source_.PoseAt(t_s), mounting_, x);
}

Vector3d FlightMatchSource::RawAt(std::size_t, double t_s, const Vector3d& p_m) const {
  return LaserVectorTo(source_.PoseAt(t_s), mounting_, p_m);
}

BareMatchSource::BareMatchSource(std::vector<MatchStrip> strips)
    : strips_(std::move(strips)), shifts_m_(strips_.size(), Vector3d::Zero()) {
  StripCloud points;
  if (!strips_.empty() && OpenStrip(strips_.front().files.front())->Next(&points)) {
    origin_c_m_ = points.p_c.front().array().round();
  }
}

StripCounts BareMatchSource::Read(std::size_t strip,
                                  const std::function<void(const RawPoints&)>& take) const {
  const MatchStrip& wanted = strips_.at(strip);
  StripCounts counts;
  RawPoints chunk;
  for (const std::filesystem::path& file : wanted.files) {
    const auto reader = OpenStrip(file);
    for (StripCloud points; reader->Next(&points);) {
      points.t_s.resize(points.size(), 0.0);  // files without time have none
      counts.points += points.size();
      Keep(wanted, points, points.p_c, &chunk, &counts);
      for (Vector3d& x : chunk.x) x -= origin_c_m_;
      if (chunk.size() > 0) take(chunk);
    }
  }
  if (counts.kept == 0) throw InvalidInput("the strip has no points", {wanted.files[0].string()});
  return counts;
}

Vector3d BareMatchSource::Position(std::size_t strip, double, const Vector3d& x) const {
  return x + shifts_m_[strip];
}

Vector3d BareMatchSource::RawAt(std::size_t strip, double, const Vector3d& p_m) const {
  return p_m - shifts_m_[strip];
}

}  // namespace dn
