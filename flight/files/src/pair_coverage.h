#pragma once

#include <dn/geo/trajectory.h>
#include <dn/imu/imu_data.h>
#include <dn/lidar/pairs.h>

#include <limits>
#include <string>
#include <vector>

namespace dn::files_internal {

/// The time covered by a data set: a span with gaps.
struct CoveredTime {
  std::string what;  ///< name of the data in messages: "the IMU data"
  double t_begin_s = -std::numeric_limits<double>::infinity();
  double t_end_s = std::numeric_limits<double>::infinity();
  std::vector<ImuGap> holes;  ///< sorted
  std::string gaps = "gaps";  ///< name of the gaps in counts: "IMU gaps"

  /// Returns the gap that contains t_s; null if there is none.
  const ImuGap* GapAt(double t_s) const;
  bool InSpan(double t_s) const { return t_s >= t_begin_s && t_s <= t_end_s; }
  bool Contains(double t_s) const { return InSpan(t_s) && GapAt(t_s) == nullptr; }
};

CoveredTime Cover(const ImuData& imu);

/// Steps of more than one second and more than five median steps are gaps of the trajectory.
CoveredTime Cover(const Trajectory& trajectory);

/// Returns t_s, or the same epoch one week later or earlier if that is inside the span and t_s is
/// not. Files of a flight may start on different sides of a week rollover.
double AlignWeek(double t_s, const CoveredTime& covered);
void AlignWeek(const CoveredTime& covered, std::vector<LidarPair>& pairs);

/// Returns the number of pairs with an epoch outside the span.
long CountOutside(const PairData& data, const CoveredTime& covered);

/// Returns the number of pairs inside the span with an epoch in a gap.
long CountInGaps(const PairData& data, const CoveredTime& covered);

/// Throws InvalidInput if an epoch is outside the span, with the first such epoch, its file and
/// line, and the span.
void ExpectInSpan(const PairData& data, const CoveredTime& covered);

/// Drops the pairs with an epoch in a gap and returns their number. Throws InvalidInput if they are
/// more than half of all pairs, because the time systems then differ or the data are unusable.
long DropInGaps(const CoveredTime& covered, PairData& data);

/// Returns a hint for a time outside the span: its unit (TimeUnitHint), or the whole hours or days
/// that would put it inside. Returns an empty string if nothing does. key: the section of
/// time_offset_s.
std::string ClockHint(double t_s, const CoveredTime& covered, const std::string& key);

/// Returns a span as text: "381253.970 .. 381646.750 s".
std::string SpanText(double t_begin_s, double t_end_s);

}  // namespace dn::files_internal
