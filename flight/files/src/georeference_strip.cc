#include <dn/error.h>
#include <dn/files/georeference_strip.h>
#include <dn/lidar/point_covariance.h>
#include <dn/parallel.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "strip_path.h"

namespace dn {
namespace {

namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using files_internal::PointFate;

constexpr std::size_t kPointsPerTask = 2048;
constexpr std::size_t kPosesOfLine = 60;

}  // namespace

struct StripGeoreferencer::Setup {
  Setup(GeoreferenceOptions given, const LocalFrame& map, const PointCrs& points)
      : options(std::move(given)),
        frame(map),
        crs(points),
        paths(options.trajectory, options.made_by, options.time_span_s, frame) {
    options.trajectory = Trajectory();  // the poses are stored in `paths`
    options.made_by.reset();
  }

  Matrix3d CovarianceInMap(const MapPose& pose, const Vector3d& u_s) const {
    const StripErrors& errors = *options.errors;
    EpochAccuracy accuracy{pose.t_s, errors.sigma_ned_m, errors.sigma_rph_rad};
    if (errors.series) accuracy = errors.series->At(pose.t_s);
    const Matrix3d R_mn = frame.R_mn(pose.p_mb);
    const Matrix3d E = BodyFromEulerRates(pose.q_mb.conjugate() * R_mn.col(2));
    PointErrors point;
    point.position_m2 = R_mn * accuracy.sigma_ned_m.cwiseAbs2().asDiagonal() * R_mn.transpose();
    point.attitude_rad2 = E * accuracy.sigma_rph_rad.cwiseAbs2().asDiagonal() * E.transpose();
    point.boresight_rad2 = errors.boresight_rad2;
    point.sigma_range_m = errors.sigma_range_m;
    point.sigma_beam_rad = errors.sigma_beam_rad;
    return PointCovariance(pose, options.mounting, u_s, point);
  }

  GeoreferenceOptions options;
  LocalFrame frame;
  PointCrs crs;
  files_internal::StripPaths paths;
};

/// The work on one strip, from the input to the output file.
class StripGeoreferencer::Work {
 public:
  Work(const Setup& setup, const fs::path& in) : setup_(setup), in_(in), reader_(OpenStrip(in)) {
    if (setup_.options.surface_cell_m) {
      before_.emplace(*setup_.options.surface_cell_m);
      after_.emplace(*setup_.options.surface_cell_m);
    }
    files_internal::ExpectTimes(*reader_, in);
    result_.origin = FindVectorOrigin(*reader_, setup_.options.made_with, in_);
    made_with_ = setup_.options.made_with.mounting;
    made_with_.boresight_rad = result_.origin.boresight_rad;
    result_.t_begin_s = std::numeric_limits<double>::infinity();
    result_.t_end_s = -result_.t_begin_s;
  }

  GeoreferencedStrip Run(const fs::path& out, const std::function<void(std::uint64_t)>& progress) {
    const auto writer = reader_->MakeWriter(out, Additions());
    for (StripCloud points; reader_->Next(&points);) {
      ExpectBeams(points);
      Renew(&points);
      writer->Append(points);
      progress(result_.points);
    }
    ExpectPoints();
    CompareWithTrajectory();
    result_.shift_rms_m = std::sqrt(shift2_m2_ / static_cast<double>(result_.kept));
    writer->Finish();
    result_.swath = {"", Line(), outline_.Corners(), outline_.MeanUp()};
    if (before_) result_.surface_before = before_->Flat();
    if (after_) result_.surface_after = after_->Flat();
    return result_;
  }

 private:
  FileLocation Where() const { return {in_.string()}; }

  StripAdditions Additions() const {
    StripAdditions additions{.covariance = setup_.options.errors.has_value()};
    // Vectors with an assumed boresight may be wrong. No boresight then describes the new points,
    // so none is recorded.
    if (result_.origin.kind != VectorOrigin::Kind::kAssumed) {
      additions.boresight_rad = setup_.options.mounting.boresight_rad;
    }
    return additions;
  }

  std::vector<Eigen::Vector3d> Line() const {
    std::vector<Eigen::Vector3d> line_m;
    for (const double tag_s : EvenTimes(result_.t_begin_s, result_.t_end_s, kPosesOfLine)) {
      const double t_s = tag_s - setup_.options.time_offset_s;
      if (setup_.paths.FindFate(t_s, reader_->has_vectors()) != PointFate::kKept) continue;
      line_m.push_back(setup_.paths.wanted().At(t_s).p_mb);
    }
    return line_m;
  }

  void Renew(StripCloud* points) {
    const std::size_t n = points->size();
    p_m_.resize(n);
    old_m_.resize(n);
    fates_.assign(n, PointFate::kKept);
    shifts_m_.assign(n, 0.0);
    if (setup_.options.errors) points->covariance_c_m2.resize(n);
    ParallelForChunks(n, kPointsPerTask, setup_.options.threads,
                      [&](std::size_t, std::size_t first, std::size_t past) {
                        for (std::size_t i = first; i < past; ++i) RenewPoint(i, points);
                      });
    Count(*points);
    std::vector<bool> drop(n);
    for (std::size_t i = 0; i < n; ++i) drop[i] = fates_[i] != PointFate::kKept;
    points->Drop(drop);
  }

  Vector3d MeasuredVector(const StripCloud& points, std::size_t i) const {
    const std::optional<BeamErrors>& beams = setup_.options.beams;
    return beams ? beams->Remove(points.u_s[i], points.beam[i]) : points.u_s[i];
  }

  /// The corrections of beams need the beam of each point.
  void ExpectBeams(const StripCloud& points) const {
    if (!setup_.options.beams || (reader_->has_vectors() && !points.beam.empty())) return;
    throw InvalidInput(
        "the points have no laser vectors with beams, so that the result's corrections of the "
        "beams cannot be applied; add the beams, or give the angles with --boresight",
        Where());
  }

  void RenewPoint(std::size_t i, StripCloud* points) {
    const double t_s = points->t_s[i] - setup_.options.time_offset_s;
    fates_[i] = setup_.paths.FindFate(t_s, reader_->has_vectors());
    if (fates_[i] != PointFate::kKept) return;
    try {
      const Vector3d old_m = old_m_[i] = setup_.crs.ToMap(points->p_c[i]);
      const MapPose pose = setup_.paths.wanted().At(t_s);
      const Vector3d u_s = reader_->has_vectors()
                               ? MeasuredVector(*points, i)
                               : LaserVectorTo(setup_.paths.maker().At(t_s), made_with_, old_m);
      const Vector3d p_m = Georeference(pose, setup_.options.mounting, u_s);
      points->p_c[i] = setup_.crs.FromMap(p_m);
      p_m_[i] = p_m;
      shifts_m_[i] = (p_m - old_m).norm();
      if (!setup_.options.errors) return;
      const Matrix3d J = setup_.crs.J_c_m(p_m);
      points->covariance_c_m2[i] = J * setup_.CovarianceInMap(pose, u_s) * J.transpose();
    } catch (const InvalidInput& e) {
      if (!e.where().file.empty()) throw;
      throw InvalidInput("point " + std::to_string(result_.points + i + 1) + ": " + e.what(),
                         Where());
    }
  }

  void Count(const StripCloud& points) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      result_.t_begin_s = std::min(result_.t_begin_s, points.t_s[i]);
      result_.t_end_s = std::max(result_.t_end_s, points.t_s[i]);
      if (fates_[i] != PointFate::kKept) {
        ++result_.dropped[files_internal::FateReason(fates_[i])];
        continue;
      }
      ++result_.kept;
      outline_.Add(points.t_s[i], p_m_[i]);
      if (before_) before_->Add(old_m_[i]);
      if (after_) after_->Add(p_m_[i]);
      shift2_m2_ += shifts_m_[i] * shifts_m_[i];
      result_.shift_max_m = std::max(result_.shift_max_m, shifts_m_[i]);
      if (sampler_.Wants()) {
        sampler_.Add({points.t_s[i] - setup_.options.time_offset_s, old_m_[i],
                      reader_->has_vectors() ? std::optional(points.u_s[i]) : std::nullopt});
      }
    }
    result_.points += points.size();
  }

  /// Compares the points of the file with the trajectory that gives them new coordinates, or gave
  /// them those of the file.
  void CompareWithTrajectory() {
    const bool own_vectors = reader_->has_vectors();
    const Mounting& mounting = setup_.options.mounting;
    const auto found = files_internal::FindStripDisagreement(
        sampler_.samples(), own_vectors ? setup_.paths.wanted() : setup_.paths.maker(), mounting,
        LargestTurn(made_with_.boresight_rad, mounting.boresight_rad));
    if (!found) return;
    const std::string text = StripDisagreementText(*found, setup_.options.time_offset_s);
    if (found->Forbids()) throw InvalidInput(text, Where());
    result_.disagreement = text;
  }

  void ExpectPoints() const {
    if (result_.points == 0) throw InvalidInput("the strip has no points", Where());
    if (result_.kept > 0) return;
    throw InvalidInput(
        files_internal::NothingLeft(result_.dropped.begin()->first, result_.t_begin_s,
                                    result_.t_end_s, setup_.paths.wanted().covered),
        Where());
  }

  const Setup& setup_;
  fs::path in_;
  std::unique_ptr<StripReader> reader_;
  GeoreferencedStrip result_;
  Mounting made_with_;
  double shift2_m2_ = 0.0;
  std::vector<PointFate> fates_;
  std::vector<double> shifts_m_;
  std::vector<Vector3d> p_m_, old_m_;
  StripSampler sampler_;
  SwathOutline outline_;
  std::optional<StripSurface> before_, after_;
};

StripGeoreferencer::StripGeoreferencer(GeoreferenceOptions options, const LocalFrame& frame,
                                       const PointCrs& crs)
    : setup_(std::make_unique<const Setup>(std::move(options), frame, crs)) {}

StripGeoreferencer::~StripGeoreferencer() = default;

GeoreferencedStrip StripGeoreferencer::Run(
    const fs::path& in, const fs::path& out,
    const std::function<void(std::uint64_t)>& progress) const {
  return Work(*setup_, in).Run(out, progress);
}

}  // namespace dn
