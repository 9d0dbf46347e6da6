#pragma once

#include <dn/files/flight.h>
#include <dn/imu/unit_agreement.h>

#include <Eigen/Core>
#include <optional>

namespace dn {

/// A mistake in the attitudes of a trajectory.
struct AttitudeMistake {
  enum class Kind {
    kRollSign,
    kPitchSign,
    kHeadingSign,
    kRollPitchExchanged,
    kInverse,  ///< the rotation is that from the navigation frame to the body
    kAxes      ///< the attitudes belong to other body axes, see R_turn
  };
  Kind kind = Kind::kAxes;
  /// For kAxes: body -> axes of the trajectory, a signed permutation.
  Eigen::Matrix3d R_turn = Eigen::Matrix3d::Identity();
  /// Root of the share of the rates of the gyros that the attitudes leave, as they were read and
  /// without the mistake. The mean rate is free, so that a gyro bias does not matter.
  double misfit_as_read = 0.0, misfit = 0.0;
};

/// Compares the turns of the trajectory with those of the gyros. shift_s: time tags of the
/// trajectory minus those of the inertial data. Returns nullopt without one of the two, if they
/// agree, and unless one mistake explains the difference.
std::optional<AttitudeMistake> FindAttitudeMistake(const Flight& flight, double shift_s = 0.0);

/// Compares the turns of the trajectory (b) with those of the gyros (a) if their clocks are
/// independent of each other, or the axes of the gyros in the body are not known. `q_ba` takes the
/// axes of the inertial data, as they were read, to those of the trajectory. Returns nullopt
/// without one of the two, if CompareUnits does, or if the turns differ by their size.
std::optional<UnitAgreement> CompareAttitudes(const Flight& flight);

}  // namespace dn
