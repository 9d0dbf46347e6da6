#pragma once

#include <dn/geo/trajectory.h>
#include <dn/imu/imu_data.h>
#include <dn/lidar/pairs.h>

#include <limits>
#include <string>
#include <vector>

namespace dn::internal {

/// The time that some data cover: a span with holes.
struct CoveredTime {
  std::string what;  ///< "the IMU data"
  double t_begin_s = -std::numeric_limits<double>::infinity();
  double t_end_s = std::numeric_limits<double>::infinity();
  std::vector<ImuGap> holes;  ///< sorted
  std::string gaps = "gaps";  ///< the holes as counts name them: "IMU gaps"

  /// The hole that t_s lies in, null when there is none.
  const ImuGap* HoleAt(double t_s) const;
  bool InSpan(double t_s) const { return t_s >= t_begin_s && t_s <= t_end_s; }
  bool Contains(double t_s) const { return InSpan(t_s) && HoleAt(t_s) == nullptr; }
};

CoveredTime Cover(const ImuData& imu);

/// A step of more than a second and of more than five usual ones is a hole of the trajectory.
CoveredTime Cover(const Trajectory& trajectory);

/// t_s, or the same epoch a week later or earlier where that falls inside the span and t_s does
/// not: files of one flight may start on different sides of a week rollover.
double AlignWeek(double t_s, const CoveredTime& covered);
void AlignWeek(const CoveredTime& covered, std::vector<LidarPair>& pairs);

/// Number of pairs with an epoch outside the span.
long CountOutside(const PairData& data, const CoveredTime& covered);

/// Number of pairs inside the span with an epoch in a hole.
long CountInHoles(const PairData& data, const CoveredTime& covered);

/// Throws InvalidInput naming the first epoch outside the span, its file and line, and the span.
void ExpectInSpan(const PairData& data, const CoveredTime& covered);

/// Drops the pairs with an epoch in a hole and returns their number. Throws InvalidInput when they
/// are more than half of all: then the time systems differ, or the data are of no use.
long DropInHoles(const CoveredTime& covered, PairData& data);

/// "381253.970 .. 381646.750 s".
std::string SpanText(double t_begin_s, double t_end_s);

}  // namespace dn::internal
