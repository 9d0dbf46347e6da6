#include "strip_path.h"

#include <dn/error.h>
#include <dn/geo/week_seconds.h>

#include <array>

namespace dn::files_internal {

std::optional<MapPose> StripPath::FindAt(double t_s) const {
  const double aligned_s = AlignWeek(t_s, covered);
  if (!covered.InSpan(aligned_s)) return std::nullopt;
  return InterpolatePose(poses, aligned_s);
}
namespace {

PointFate FateBy(const CoveredTime& covered, double t_s) {
  const double aligned_s = AlignWeek(t_s, covered);
  if (aligned_s < covered.t_begin_s) return PointFate::kBefore;
  if (aligned_s > covered.t_end_s) return PointFate::kAfter;
  return covered.GapAt(aligned_s) != nullptr ? PointFate::kInGap : PointFate::kKept;
}

}  // namespace

const char* FateReason(PointFate fate) {
  constexpr std::array<const char*, 6> kReasons{"",
                                                "before the trajectory",
                                                "after the trajectory",
                                                "in trajectory gaps",
                                                "outside the trajectory of the points",
                                                "outside time span"};
  return kReasons[static_cast<std::size_t>(fate)];
}

StripPaths::StripPaths(const Trajectory& trajectory, const std::optional<Trajectory>& made_by,
                       const std::optional<Eigen::Vector2d>& time_span_s, const LocalFrame& frame)
    : wanted_(trajectory, frame) {
  if (made_by) other_maker_.emplace(*made_by, frame);
  if (!time_span_s) return;
  span_.t_begin_s = time_span_s->x();
  span_.t_end_s = time_span_s->y();
}

PointFate StripPaths::FindFate(double t_s, bool own_vectors) const {
  if (!span_.InSpan(AlignWeek(t_s, span_))) return PointFate::kOutsideSpan;
  const PointFate fate = FateBy(wanted_.covered, t_s);
  if (fate != PointFate::kKept || own_vectors || !other_maker_) return fate;
  const PointFate made = FateBy(other_maker_->covered, t_s);
  return made == PointFate::kKept ? made : PointFate::kOutsideMaker;
}

void ExpectTimes(const StripReader& reader, const std::filesystem::path& file) {
  if (reader.has_time()) return;
  throw InvalidInput(
      "the points have no GPS time, so their poses are unknown; export the strip with GPS time "
      "(LAS point format 1, 3 or 6 and more)",
      {file.string()});
}

std::string NothingLeft(const std::string& reason, double t_begin_s, double t_end_s,
                        const CoveredTime& covered) {
  const std::string unit = ClockHint(0.5 * (t_begin_s + t_end_s), covered, "lidar");
  return "no point can be georeferenced: all lie " + reason + ": the strip covers " +
         SpanText(t_begin_s, t_end_s) + ", the trajectory " +
         SpanText(covered.t_begin_s, covered.t_end_s) +
         (unit.empty() ? "; check the type of GPS time in the file" : unit);
}

std::optional<StripDisagreement> FindStripDisagreement(const std::vector<StripSample>& samples,
                                                       const StripPath& path,
                                                       const Mounting& mounting,
                                                       double largest_turn_rad) {
  return FindStripDisagreement(
      samples, [&path](double t_s) { return path.FindAt(t_s); }, path.covered.t_begin_s,
      path.covered.t_end_s, mounting, largest_turn_rad);
}

}  // namespace dn::files_internal
