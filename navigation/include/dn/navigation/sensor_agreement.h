#pragma once

#include <dn/flight/flight.h>

#include <Eigen/Core>
#include <optional>

namespace dn {

// What inertial and GNSS data show of axes, clocks and coordinates before any adjustment. They need
// no stochastic model.

/// Where gravity and the course lie in the body axes as declared.
struct BodyDirections {
  Eigen::Vector3d down_b = Eigen::Vector3d::UnitZ();  ///< mean, unit
  /// Length of the mean specific force over the mean of its lengths: near 1 unless the body turns
  /// over.
  double down_agreement = 0.0;
  /// Mean course at right angles to down_b, unit; absent where the flight does not tell it: too
  /// slow, or without a turn.
  std::optional<Eigen::Vector3d> course_b;
  /// Length of the mean of the unit vectors that course_b is the mean of.
  double course_agreement = 0.0;
};

/// The attitude is found anew in every half minute of the flight, as by the alignment in flight, so
/// that no start value and no gyro bias that is usual (1000 deg/h turns it by 8 deg) matters. GNSS may
/// be absent: then there is no course.
BodyDirections FindBodyDirections(const Flight& flight, int threads = 1);

/// How far the axes lie from the nearest of the 24 that an instrument can be put in.
struct AxesFit {
  Eigen::Matrix3d R_turn = Eigen::Matrix3d::Identity();  ///< declared -> true body, a permutation
  double distance_rad = 0.0;                             ///< of the directions from R_turn's
};

/// The turn that takes down_b to body z and course_b to body x, or without a course down_b to body z
/// by the smaller turn.
AxesFit FitAxes(const BodyDirections& directions);

/// A mistake in the axes of an inertial sensor.
struct AxesMistake {
  enum class Sensor { kGyro, kAccel, kBoth };
  Sensor sensor = Sensor::kGyro;
  /// Data as declared to right data: one sign, an exchange of two axes, all signs, or of the gyros
  /// 180/pi or pi/180 (rad/s declared as deg/s, and the reverse).
  Eigen::Matrix3d M = Eigen::Matrix3d::Identity();
};

/// The one mistake without which specific force, rates and GNSS positions fit each other, in the
/// axes of the file. Nullopt where they fit as they are, or where no mistake of the kind explains
/// the misfit or several do. Reflections of both sensors together count as one, all signs. Mirrored
/// positions (latitude and longitude exchanged) look like specific forces with all signs reversed.
///
/// By alignments in flight over windows of half a minute, whose misfit is the acceleration that the
/// best attitude leaves. Costs about two dozen of FindBodyDirections.
std::optional<AxesMistake> FindAxesMistake(const Flight& flight, int threads = 1);

/// Turns of the course against those that the gyros show, with the GNSS tags moved by a lag.
struct TurnComparison {
  double correlation = 0.0;       ///< as tagged, of the turns over 2 s and more, in -1..1
  double best_correlation = 0.0;  ///< of the largest absolute value within 40 s
  double best_lag_s = 0.0;        ///< GNSS tags are late by this, to a quarter second
  double turned_rad = 0.0;        ///< sum of the course changes
};

/// Absent where the flight does not turn, by less than half a circle in all: nothing to compare. A
/// correlation near -1 is a course that is mirrored.
std::optional<TurnComparison> CompareTurns(const Flight& flight);

}  // namespace dn
