#pragma once

#include <dn/shared_list.h>

#include <Eigen/Core>
#include <memory>

namespace dn {

/// What a file says of one laser vector on its way to what is true, with the derivatives that it
/// carries.
struct LidarReading {
  double tag_s = 0.0;                                    ///< time tag of the file
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();         ///< laser vector in the sensor frame, m
  double delay_s = 0.0;                                  ///< the epoch is tag - delay
  Eigen::Vector3d turn_b_rad = Eigen::Vector3d::Zero();  ///< added to the boresight's rotation
                                                         ///< vector
  /// With respect to the values of all effects, in their order.
  Eigen::Matrix3Xd J_u, J_turn;
  Eigen::RowVectorXd J_delay;

  /// A reading without effects, with room for the derivatives of `columns` values.
  static LidarReading Of(double tag_s, const Eigen::Vector3d& u_s, Eigen::Index columns) {
    LidarReading reading;
    reading.tag_s = tag_s;
    reading.u_s = u_s;
    reading.J_u.setZero(3, columns);
    reading.J_turn.setZero(3, columns);
    reading.J_delay.setZero(columns);
    return reading;
  }
};

/// A constant error of a lidar or of its mount, exact in its size.
class LidarEffect {
 public:
  virtual ~LidarEffect() = default;

  /// Number of values.
  virtual int components() const = 0;

  /// Whether it changes epochs.
  virtual bool moves_epochs() const { return false; }

  /// Takes the error out of the reading, carries J_u along where it turns or stretches the laser
  /// vector, and writes the derivatives with respect to `value` into the columns from `column` on,
  /// which are zero on entry. A value of zero leaves the reading as it is.
  virtual void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
                       LidarReading* reading) const = 0;
};

using LidarEffects = SharedList<std::shared_ptr<const LidarEffect>>;

/// Components of all effects.
inline Eigen::Index TotalComponents(const LidarEffects& effects) {
  Eigen::Index n = 0;
  for (const auto& effect : effects) n += effect->components();
  return n;
}

/// The reading with every effect taken out, in their order; `values`: of each.
inline LidarReading Corrected(const LidarEffects& effects, double const* const* values,
                              double tag_s, const Eigen::Vector3d& u_s) {
  LidarReading reading = LidarReading::Of(tag_s, u_s, TotalComponents(effects));
  Eigen::Index column = 0;
  for (std::size_t k = 0; k < effects.size(); ++k) {
    const int components = effects[k]->components();
    effects[k]->Correct(Eigen::Map<const Eigen::VectorXd>(values[k], components), column, &reading);
    column += components;
  }
  return reading;
}

}  // namespace dn
