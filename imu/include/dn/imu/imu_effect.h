#pragma once

#include <dn/shared_list.h>

#include <Eigen/Core>
#include <memory>
#include <string>

namespace dn {

/// Rate and specific force over a stretch of one sample on their way from measured to true, with
/// the derivatives that they carry.
struct ImuReading {
  double t_s = 0.0;  ///< middle of the stretch
  Eigen::Vector3d w_b, f_b;
  /// d w_b and d f_b with respect to the gyro bias (3), the accelerometer bias (3) and the values
  /// of all effects, in their order.
  Eigen::Matrix3Xd J_w, J_f;
};

/// A constant error of the inertial sensors, exact in its size: what the data of a sensor contain
/// and the corrected ones must not. Derive from it for an error of your own (a bias that ramps,
/// say): the increments then carry its derivative as they carry those of the biases.
class ImuEffect {
 public:
  virtual ~ImuEffect() = default;

  /// Number of values.
  virtual int components() const = 0;

  /// Takes the error out of the reading, carries the derivatives along (every column of J_w and
  /// J_f), and writes those with respect to `value` into the columns from `column` on, which are
  /// zero on entry. A correction that is not linear in the reading leaves its curvature out of the
  /// slopes within a sample.
  virtual void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
                       ImuReading* reading) const = 0;
};

/// An effect of the inertial sensors with its size, SI.
struct ImuEffectValue {
  std::shared_ptr<const ImuEffect> effect;
  Eigen::VectorXd value;
};

using ImuEffectValues = SharedList<ImuEffectValue>;

/// Components of all effects.
inline Eigen::Index TotalComponents(const ImuEffectValues& effects) {
  Eigen::Index n = 0;
  for (const ImuEffectValue& one : effects) n += one.value.size();
  return n;
}

}  // namespace dn
