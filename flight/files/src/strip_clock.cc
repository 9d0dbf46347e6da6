#include "strip_clock.h"

#include <dn/files/pair_clock.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

namespace dn::files_internal {
namespace {

constexpr double kLeastClockSpeedMps = 3.0, kFewestPoints = 10.0;
constexpr double kLeastOffsetS = 0.5;
// No mounting is wrong by more, and no scanner looks more forward.
const double kLargestMounting = std::tan(10.0 / 180.0 * std::numbers::pi);
const double kLargestLook = std::tan(30.0 / 180.0 * std::numbers::pi);
// If the clock is the cause, most of the distance lies along the course, and it is nearly constant.
constexpr double kAlongCourse = 0.8, kMostSpread = 0.25;

}  // namespace

void StripClock::Take(const MapPose& pose, const Eigen::Vector3d& in_file_m,
                      const Eigen::Vector3d& by_trajectory_m) {
  const Eigen::Vector3d v_m(pose.v_m.x(), pose.v_m.y(), 0.0);
  const double speed_mps = v_m.norm();
  if (speed_mps < kLeastClockSpeedMps) return;
  const Eigen::Vector3d apart_m = in_file_m - (has_vectors_ ? by_trajectory_m : pose.p_mb);
  count_ += 1.0;
  const double along_m = apart_m.dot(v_m) / speed_mps;
  along_m_ += along_m;
  along2_m2_ += along_m * along_m;
  apart2_m2_ += apart_m.head<2>().squaredNorm();
  speed_mps_ += speed_mps;
  range_m_ += std::abs(pose.p_mb.z() - by_trajectory_m.z());
}

void StripClock::ExpectAgreement(double declared_s, const FileLocation& where) const {
  const std::optional<double> offset_s = Offset();
  if (!offset_s) return;
  throw InvalidInput("the points lie along the course " +
                         std::to_string(std::lround(std::abs(along_m_ / count_))) +
                         " m from where the trajectory puts them; their time tags seem " +
                         LidarClockHint(*offset_s, declared_s),
                     where);
}

std::optional<double> StripClock::Offset() const {
  if (count_ < kFewestPoints) return std::nullopt;
  const double along_m = along_m_ / count_, range_m = range_m_ / count_;
  const double apart_m = std::sqrt(apart2_m2_ / count_);
  const double most_m = range_m * (has_vectors_ ? kLargestMounting : kLargestLook);
  // A point that is tagged early lies ahead of the pose at its tag.
  const double offset_s = -along_m / (speed_mps_ / count_);
  const double spread_m = std::sqrt(std::max(0.0, along2_m2_ / count_ - along_m * along_m));
  if (spread_m > kMostSpread * std::abs(along_m) || std::abs(along_m) < most_m ||
      std::abs(along_m) < kAlongCourse * apart_m)
    return std::nullopt;
  return std::abs(offset_s) >= kLeastOffsetS ? std::optional(offset_s) : std::nullopt;
}

}  // namespace dn::files_internal
