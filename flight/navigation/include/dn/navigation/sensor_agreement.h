#pragma once

#include <dn/files/flight.h>

#include <Eigen/Core>
#include <optional>

namespace dn {

// These functions check axes, clocks and coordinates with the inertial and GNSS data before any
// adjustment. They need no stochastic model.

/// Directions of gravity and of the course in the body axes as configured.
struct BodyDirections {
  Eigen::Vector3d down_b = Eigen::Vector3d::UnitZ();  ///< mean direction of gravity, unit vector
  /// Length of the mean specific force divided by the mean of its lengths: near 1 unless the body
  /// turns over.
  double down_agreement = 0.0;
  /// Mean course perpendicular to down_b, unit vector. Absent if the flight does not determine it:
  /// too slow, or without a turn.
  std::optional<Eigen::Vector3d> course_b;
  /// Length of the mean of the unit course vectors, 0 to 1.
  double course_agreement = 0.0;
};

/// Determines the mean directions of gravity and course in body axes. The attitude is determined
/// again every half minute by in-flight alignment. The result therefore does not depend on an
/// initial value. Common gyro biases do not matter: 1000 deg/h turns the result by 8 deg. The
/// result has no course if GNSS is absent.
BodyDirections FindBodyDirections(const Flight& flight, int threads = 1);

/// The nearest of the 24 possible orientations of an instrument with parallel axes, and the
/// distance from it.
struct AxesFit {
  /// Configured -> true body axes, a signed permutation.
  Eigen::Matrix3d R_turn = Eigen::Matrix3d::Identity();
  /// Largest angle of gravity or course from the axis assigned by R_turn.
  double distance_rad = 0.0;
};

/// Returns the rotation that takes down_b to body z and course_b to body x. Without a course it is
/// the smallest rotation that takes down_b to body z.
AxesFit FitAxes(const BodyDirections& directions);

/// A mistake in the axes of an inertial sensor.
struct AxesMistake {
  enum class Sensor { kGyro, kAccel, kBoth };
  Sensor sensor = Sensor::kGyro;
  /// Matrix from the declared to the right data. It changes one sign, exchanges two axes, or
  /// changes all signs. For gyros it may also be a factor of 180/pi or pi/180 (rad/s declared as
  /// deg/s, and the reverse).
  Eigen::Matrix3d M = Eigen::Matrix3d::Identity();
};

/// Returns the one mistake without which specific force, rates and GNSS positions agree, in the
/// axes of the file. Returns nullopt if they agree as they are, or if no mistake or several
/// mistakes of this kind explain the misfit. Reflections of both sensors together count as one, all
/// signs. Mirrored positions (latitude and longitude exchanged) look like specific forces with all
/// signs reversed.
///
/// The misfit is the acceleration that the best attitude leaves in in-flight alignments over
/// windows of half a minute. The cost is about two dozen times that of FindBodyDirections.
std::optional<AxesMistake> FindAxesMistake(const Flight& flight, int threads = 1);

/// Comparison of the turns of the course with those of the gyros, with the GNSS tags shifted by a
/// lag.
struct TurnComparison {
  double correlation = 0.0;  ///< at lag 0, over turns of 2 s or longer, in -1..1
  /// Correlation with the largest absolute value within lags of 40 s.
  double best_correlation = 0.0;
  double best_lag_s = 0.0;  ///< delay of the GNSS tags, in steps of a quarter second
  double turned_rad = 0.0;  ///< sum of the absolute course changes
};

/// Compares the turns of the course with those of the gyros. Returns nullopt if the flight turns by
/// less than half a circle in total. A correlation near -1 indicates mirrored coordinates.
std::optional<TurnComparison> CompareTurns(const Flight& flight);

}  // namespace dn
