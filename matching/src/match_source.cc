#include <dn/error.h>
#include <dn/geo/point_crs.h>
#include <dn/lidar/strip_io.h>
#include <dn/matching/match_source.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

namespace dn {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

/// Returns whether a point belongs to the strip.
bool BelongsTo(const MatchStrip& wanted, const std::vector<std::uint16_t>& source, std::size_t i) {
  return !wanted.source || (!source.empty() && source[i] == *wanted.source);
}

/// Adds the counts of a file, except the kept points.
void Join(const StripCounts& file, StripCounts* all) {
  const bool first = all->points == 0;
  all->origin = all->origin ? Weaker(*all->origin, *file.origin) : *file.origin;
  all->t_begin_s = first ? file.t_begin_s : std::min(all->t_begin_s, file.t_begin_s);
  all->t_end_s = first ? file.t_end_s : std::max(all->t_end_s, file.t_end_s);
  all->points += file.points;
  for (const auto& [reason, count] : file.dropped) all->dropped[reason] += count;
}

/// Returns the transformation of positions from one map frame to another.
Eigen::Isometry3d FromTo(const LocalFrame& from, const LocalFrame& to) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = to.R_me() * from.R_me().transpose();
  T.translation() = T.linear() * from.r0_m() - to.r0_m();
  return T;
}

/// Returns metres per unit of the coordinates of all strips, by the systems in their headers.
/// Throws InvalidInput if two files have different units.
Vector3d FindUnits(const std::vector<MatchStrip>& strips) {
  std::optional<Vector3d> unit_m;
  for (const MatchStrip& strip : strips) {
    for (const fs::path& file : strip.files) {
      const StripCrs crs = OpenStrip(file)->crs();
      const Vector3d own_m = crs.in_metres ? Vector3d(Vector3d::Ones()) : CrsUnitsM(crs.name);
      if (unit_m && own_m != *unit_m) {
        throw InvalidInput(
            "the coordinates have other units than those of the first strip, by the coordinate "
            "systems in the headers; convert the strips to the same system",
            {file.string()});
      }
      unit_m = own_m;
    }
  }
  return unit_m.value_or(Vector3d::Ones());
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

FlightMatchSource::FlightMatchSource(const StripSourceOptions& options, const LocalFrame& frame,
                                     const std::string& strips_crs, std::vector<MatchStrip> strips)
    : mounting_(options.made_with.mounting),
      frame_(frame),
      source_(options, frame, strips_crs),
      strips_(std::move(strips)) {}

StripCounts FlightMatchSource::Read(std::size_t strip,
                                    const std::function<void(const RawPoints&)>& take) const {
  const MatchStrip& wanted = strips_.at(strip);
  StripCounts counts;
  RawPoints kept;
  for (const std::filesystem::path& file : wanted.files) {
    Join(source_.Read(file,
                      [&](const LaserVectors& vectors) {
                        kept.Clear();
                        for (std::size_t i = 0; i < vectors.size(); ++i) {
                          if (BelongsTo(wanted, vectors.source, i)) {
                            kept.Add(vectors.t_s[i], vectors.u_s[i]);
                            if (!vectors.beam.empty()) kept.beam.push_back(vectors.beam[i]);
                          }
                        }
                        counts.kept += kept.size();
                        if (kept.size() > 0) take(kept);
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

ScannersMatchSource::ScannersMatchSource(std::vector<Scanner> scanners)
    : scanners_(std::move(scanners)) {
  for (std::size_t k = 0; k < scanners_.size(); ++k) {
    const std::vector<MatchStrip>& strips = scanners_[k].source->strips();
    for (std::size_t s = 0; s < strips.size(); ++s) {
      strips_.push_back(strips[s]);
      strips_.back().name = scanners_[k].name + "_" + strips[s].name;
      places_.push_back({k, s});
    }
    to_first_frame_.push_back(
        FromTo(scanners_[k].source->frame(), scanners_.front().source->frame()));
  }
}

StripCounts ScannersMatchSource::Read(std::size_t strip,
                                      const std::function<void(const RawPoints&)>& take) const {
  return Source(strip).Read(StripIndex(strip), take);
}

Vector3d ScannersMatchSource::Position(std::size_t strip, double t_s, const Vector3d& x) const {
  return ToFirstFrame(strip) * Source(strip).Position(StripIndex(strip), t_s, x);
}

Vector3d ScannersMatchSource::RawAt(std::size_t strip, double t_s, const Vector3d& p_m) const {
  return Source(strip).RawAt(StripIndex(strip), t_s, ToFirstFrame(strip).inverse() * p_m);
}

Eigen::Matrix3d ScannersMatchSource::TurnDerivative(std::size_t strip, double t_s,
                                                    const Vector3d& x) const {
  const FlightMatchSource& own = Source(strip);
  return -ToFirstFrame(strip).linear() * own.PoseAt(t_s).q_mb.toRotationMatrix() *
         Skew(LaserVectorInBody(own.mounting(), x));
}

std::optional<Vector3d> ScannersMatchSource::BodyPosition(std::size_t strip, double t_s) const {
  return ToFirstFrame(strip) * *Source(strip).BodyPosition(StripIndex(strip), t_s);
}

BareMatchSource::BareMatchSource(std::vector<MatchStrip> strips, PointFilter filter)
    : strips_(std::move(strips)),
      filter_(std::move(filter)),
      shifts_m_(strips_.size(), Vector3d::Zero()) {
  unit_m_ = FindUnits(strips_);
  StripCloud points;
  if (!strips_.empty() && OpenStrip(strips_.front().files.front())->Next(&points)) {
    origin_c_ = points.p_c.front().array().round();
  }
}

StripCounts BareMatchSource::Read(std::size_t strip,
                                  const std::function<void(const RawPoints&)>& take) const {
  const MatchStrip& wanted = strips_.at(strip);
  StripCounts counts;
  RawPoints kept;
  for (const std::filesystem::path& file : wanted.files) {
    const auto reader = OpenStrip(file);
    for (StripCloud points; reader->Next(&points);) {
      kept.Clear();
      for (std::size_t i = 0; i < points.size(); ++i) {
        if (!BelongsTo(wanted, points.source, i)) continue;
        if (const char* reason = DropReason(filter_, points, i)) {
          ++counts.dropped[reason];
        } else {
          kept.Add(points.t_s.empty() ? 0.0 : points.t_s[i],
                   (points.p_c[i] - origin_c_).cwiseProduct(unit_m_));
          if (!points.beam.empty()) kept.beam.push_back(points.beam[i]);
        }
      }
      counts.points += points.size();
      counts.kept += kept.size();
      if (kept.size() > 0) take(kept);
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
