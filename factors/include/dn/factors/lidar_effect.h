#pragma once

#include <dn/eigen_alignment.h>
#include <dn/lidar/beam.h>
#include <dn/shared_list.h>

#include <Eigen/Core>
#include <memory>

namespace dn {

/// One laser vector of a file with the corrections of all effects, and their derivatives.
struct LidarReading {
  double tag_s = 0.0;                             ///< time tag in the file
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();  ///< laser vector in the sensor frame, m
  double delay_s = 0.0;                           ///< true epoch = tag - delay
  /// Added to the boresight's rotation vector.
  Eigen::Vector3d turn_b_rad = Eigen::Vector3d::Zero();
  Eigen::Vector3d arm_b_m = Eigen::Vector3d::Zero();  ///< added to the lever arm
  /// Derivatives with respect to the values of all effects, in their order.
  Eigen::Matrix3Xd J_u, J_turn, J_arm;
  Eigen::RowVectorXd J_delay;
  int scanner = 0;     ///< index of the scanner, for effects that act on one of several
  int beam = kNoBeam;  ///< beam of the scanner, for effects that act on one of several

  /// Returns a reading without corrections, with zero derivatives for `columns` values.
  static LidarReading Uncorrected(double tag_s, const Eigen::Vector3d& u_s, Eigen::Index columns) {
    LidarReading reading;
    reading.tag_s = tag_s;
    reading.u_s = u_s;
    reading.J_u.setZero(3, columns);
    reading.J_turn.setZero(3, columns);
    reading.J_arm.setZero(3, columns);
    reading.J_delay.setZero(columns);
    return reading;
  }
};

/// A constant error of a lidar or of its mount; the correction is exact for any size of the error.
class LidarEffect {
 public:
  virtual ~LidarEffect() = default;

  /// Returns the number of values.
  virtual int components() const = 0;

  /// Returns true if the effect changes epochs.
  virtual bool moves_epochs() const { return false; }

  /// Removes the error from the reading. Transforms J_u if the effect rotates or scales the laser
  /// vector. Writes the derivatives with respect to `value` to the columns from `column` on, which
  /// are zero on entry. A value of zero does not change the reading.
  virtual void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
                       LidarReading* reading) const = 0;
};

using LidarEffects = SharedList<std::shared_ptr<const LidarEffect>>;

/// Returns the total number of components of all effects.
inline Eigen::Index TotalComponents(const LidarEffects& effects) {
  Eigen::Index n = 0;
  for (const auto& effect : effects) n += effect->components();
  return n;
}

/// Returns the reading after removing every effect in order; `values` has one pointer to the values
/// of each effect.
inline LidarReading Corrected(const LidarEffects& effects, double const* const* values,
                              double tag_s, const Eigen::Vector3d& u_s, int scanner = 0,
                              int beam = kNoBeam) {
  LidarReading reading = LidarReading::Uncorrected(tag_s, u_s, TotalComponents(effects));
  reading.scanner = scanner;
  reading.beam = beam;
  Eigen::Index column = 0;
  for (std::size_t k = 0; k < effects.size(); ++k) {
    const int components = effects[k]->components();
    effects[k]->Correct(Eigen::Map<const Eigen::VectorXd>(values[k], components), column, &reading);
    column += components;
  }
  return reading;
}

}  // namespace dn
