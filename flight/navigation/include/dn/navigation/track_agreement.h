#pragma once

#include <dn/files/flight.h>

#include <Eigen/Core>
#include <optional>

namespace dn {

/// A mistake in the coordinates of a file that moves it to another place.
enum class PlaceMistake {
  kNone,
  kExchanged,          ///< latitude and longitude are exchanged in one of the files
  kTrajectoryRadians,  ///< the trajectory has radians that were read as degrees
  kGnssRadians,        ///< the same for GNSS
  kElsewhere           ///< no such mistake brings the files to one place
};

/// The cause of a difference between the heights of a trajectory and those of GNSS.
enum class HeightMistake { kNone, kConstant, kTrajectoryFeet, kGnssFeet };

/// Differences between the trajectory and the GNSS positions, with the lever arm of the antenna.
struct TrackComparison {
  PlaceMistake place = PlaceMistake::kNone;
  double distance_m = 0.0;  ///< between the middles of the two tracks as they were read
  /// For kExchanged: mean cosine between heading and course of the trajectory as it was read, and
  /// with latitude and longitude exchanged. It is near 1 for the right reading.
  double course_as_read = 0.0, course_exchanged = 0.0;
  /// False if no shift of the time tags makes the tracks agree. The rest is then undefined.
  bool one_motion = false;
  /// Time tags of the trajectory minus those of GNSS, s; 0 if they agree.
  double shift_s = 0.0;
  /// Mean difference east, north, up of the trajectory from GNSS after the shift; heights as they
  /// were read.
  Eigen::Vector3d apart_enu_m = Eigen::Vector3d::Zero();
  HeightMistake height = HeightMistake::kNone;
  /// A smaller difference is not told: a lever arm that is not declared, and the noise.
  double tolerance_m = 0.0;

  bool Agrees() const;
};

/// Compares the positions of the trajectory with those of GNSS in place, time and height. The shift
/// is that of the moving epochs for which the median horizontal distance is smallest; all shifts at
/// which half of them meet the trajectory are tried. Returns nullopt without one of the two.
std::optional<TrackComparison> CompareTracks(const Flight& flight);

}  // namespace dn
