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

  /// The hole that t_s lies in, null when there is none.
  const ImuGap* HoleAt(double t_s) const;
  bool Contains(double t_s) const;
};

CoveredTime Cover(const ImuData& imu);

/// A step of more than a second and of more than five usual ones is a hole of the trajectory.
CoveredTime Cover(const Trajectory& trajectory);

/// t_s, or the same epoch a week later or earlier where that falls inside the span and t_s does
/// not: files of one flight may start on different sides of a week rollover.
double AlignWeek(double t_s, const CoveredTime& covered);
void AlignWeek(const CoveredTime& covered, std::vector<LidarPair>& pairs);

/// Number of pairs with an epoch that is not covered.
long CountUncovered(const PairData& data, const CoveredTime& covered);

/// Throws InvalidInput naming the first epoch that is not covered, its file and line, and the span.
void ExpectCovered(const PairData& data, const CoveredTime& covered);

/// "381253.970 .. 381646.750 s".
std::string SpanText(double t_begin_s, double t_end_s);

}  // namespace dn::internal
