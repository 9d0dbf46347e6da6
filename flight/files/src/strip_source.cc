#include <dn/error.h>
#include <dn/files/strip_source.h>
#include <dn/lidar/strip_io.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "strip_path.h"

namespace dn {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;
using files_internal::PointFate;

}  // namespace

struct StripSource::Setup {
  Setup(const StripSourceOptions& options, const LocalFrame& frame, const std::string& strips_crs)
      : crs(strips_crs, frame),
        made_with(options.made_with),
        time_offset_s(options.time_offset_s),
        filter(options.filter),
        paths(options.trajectory, options.made_by, options.time_span_s, frame) {}

  Vector3d PointLaserVector(const StripCloud& points, std::size_t i, double t_s,
                            const Mounting& mounting) const {
    if (!points.u_s.empty()) return points.u_s[i];
    return LaserVectorTo(paths.maker().At(t_s), mounting, crs.ToMap(points.p_c[i]));
  }

  /// Throws InvalidInput if the points cannot belong to the trajectory.
  void ExpectAgreement(const std::vector<StripSample>& samples, const Mounting& mounting,
                       bool own_vectors, const FileLocation& where) const {
    const auto found = files_internal::FindStripDisagreement(
        samples, own_vectors ? paths.wanted() : paths.maker(), mounting,
        LargestTurn(Vector3d::Zero(), mounting.boresight_rad));
    if (found && found->Forbids()) {
      throw InvalidInput(StripDisagreementText(*found, time_offset_s), where);
    }
  }

  PointCrs crs;
  StripGeoreferencing made_with;
  double time_offset_s;
  PointFilter filter;
  files_internal::StripPaths paths;
};

StripSource::StripSource(const StripSourceOptions& options, const LocalFrame& frame,
                         const std::string& strips_crs)
    : setup_(std::make_unique<const Setup>(options, frame, strips_crs)) {}

StripSource::~StripSource() = default;

MapPose StripSource::PoseAt(double t_s) const { return setup_->paths.wanted().At(t_s); }

StripCounts StripSource::Read(const fs::path& file,
                              const std::function<void(const LaserVectors&)>& take) const {
  const auto reader = OpenStrip(file);
  const FileLocation where{file.string()};
  files_internal::ExpectTimes(*reader, file);
  StripCounts counts;
  const VectorOrigin& origin =
      counts.origin.emplace(FindVectorOrigin(*reader, setup_->made_with, file));
  Mounting mounting = setup_->made_with.mounting;
  mounting.boresight_rad = origin.boresight_rad;
  counts.t_begin_s = std::numeric_limits<double>::infinity();
  counts.t_end_s = -counts.t_begin_s;
  double all_begin_s = counts.t_begin_s, all_end_s = counts.t_end_s;
  LaserVectors vectors;
  StripSampler sampler;
  for (StripCloud points; reader->Next(&points);) {
    vectors.t_s.clear();
    vectors.u_s.clear();
    vectors.source.clear();
    vectors.beam.clear();
    for (std::size_t i = 0; i < points.size(); ++i) {
      ++counts.points;
      const double t_s = points.t_s[i] - setup_->time_offset_s;
      all_begin_s = std::min(all_begin_s, t_s);
      all_end_s = std::max(all_end_s, t_s);
      const PointFate fate = setup_->paths.FindFate(t_s, reader->has_vectors());
      if (fate != PointFate::kKept) {
        ++counts.dropped[files_internal::FateReason(fate)];
        continue;
      }
      if (const char* reason = DropReason(setup_->filter, points, i)) {
        ++counts.dropped[reason];
        continue;
      }
      if (!points.source.empty()) vectors.source.push_back(points.source[i]);
      if (!points.beam.empty()) vectors.beam.push_back(points.beam[i]);
      vectors.t_s.push_back(files_internal::AlignWeek(t_s, setup_->paths.wanted().covered));
      try {
        vectors.u_s.push_back(setup_->PointLaserVector(points, i, t_s, mounting));
      } catch (const InvalidInput& e) {
        throw InvalidInput("point " + std::to_string(counts.points) + ": " + e.what(), where);
      }
      counts.t_begin_s = std::min(counts.t_begin_s, vectors.t_s.back());
      counts.t_end_s = std::max(counts.t_end_s, vectors.t_s.back());
      if (sampler.Wants()) {
        sampler.Add({t_s, setup_->crs.ToMap(points.p_c[i]),
                     points.u_s.empty() ? std::nullopt : std::optional(points.u_s[i])});
      }
    }
    counts.kept += vectors.size();
    if (vectors.size() > 0) take(vectors);
  }
  if (counts.points == 0) throw InvalidInput("the strip has no points", where);
  if (counts.kept == 0) {
    throw InvalidInput(files_internal::NothingLeft(counts.dropped.begin()->first, all_begin_s,
                                                   all_end_s, setup_->paths.wanted().covered),
                       where);
  }
  setup_->ExpectAgreement(sampler.samples(), mounting, reader->has_vectors(), where);
  return counts;
}

}  // namespace dn
