#include "strip_path.h"

#include <dn/geo/week_seconds.h>

#include <array>

namespace dn::internal {

const char* ReasonOf(PointFate fate) {
  constexpr std::array<const char*, 6> kReasons{"",
                                                "before the trajectory",
                                                "after the trajectory",
                                                "in trajectory gaps",
                                                "outside the trajectory of the points",
                                                "outside time span"};
  return kReasons[static_cast<std::size_t>(fate)];
}

PointFate FateBy(const CoveredTime& covered, double t_s) {
  const double aligned_s = AlignWeek(t_s, covered);
  if (aligned_s < covered.t_begin_s) return PointFate::kBefore;
  if (aligned_s > covered.t_end_s) return PointFate::kAfter;
  return covered.HoleAt(aligned_s) != nullptr ? PointFate::kInGap : PointFate::kKept;
}

std::string NothingLeft(const std::string& reason, double t_begin_s, double t_end_s,
                        const CoveredTime& covered) {
  const std::string unit = TimeUnitHint(t_begin_s, covered.t_begin_s, covered.t_end_s);
  return "no point can be georeferenced, all lie " + reason + ": the strip covers " +
         SpanText(t_begin_s, t_end_s) + ", the trajectory " +
         SpanText(covered.t_begin_s, covered.t_end_s) +
         (unit.empty() ? "; is the kind of GPS time in the file right?" : unit);
}

}  // namespace dn::internal
