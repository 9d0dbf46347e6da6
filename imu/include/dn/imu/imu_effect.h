#pragma once

#include <dn/eigen_alignment.h>
#include <dn/shared_list.h>

#include <Eigen/Core>
#include <memory>
#include <string>

namespace dn {

/// Rate and specific force during part of one sample, while they are corrected from measured to
/// true values. The derivatives are propagated with them.
struct ImuReading {
  double t_s = 0.0;  ///< middle of this part of the sample
  Eigen::Vector3d w_b, f_b;
  /// Derivatives of w_b and f_b with respect to the gyro bias (3), the accelerometer bias (3) and
  /// the values of all effects, in their order.
  Eigen::Matrix3Xd J_w, J_f;
};

/// Constant error of the inertial sensors, corrected without linearisation in its size. Derive a
/// class from it for an error of your own, such as a bias ramp. The increments then propagate its
/// derivatives in the same way as those of the biases.
class ImuEffect {
 public:
  virtual ~ImuEffect() = default;

  /// Number of components of the value.
  virtual int components() const = 0;

  /// Removes the error from the reading and updates the derivatives (every column of J_w and J_f).
  /// The derivatives with respect to `value` go into the columns from `column` on, which are zero
  /// on entry. If the correction is not linear in the reading, its curvature is neglected in the
  /// slopes within a sample.
  virtual void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
                       ImuReading* reading) const = 0;
};

/// Effect of the inertial sensors with its value, SI.
struct ImuEffectValue {
  std::shared_ptr<const ImuEffect> effect;
  Eigen::VectorXd value;
};

using ImuEffectValues = SharedList<ImuEffectValue>;

/// Returns the number of components of all effects.
inline Eigen::Index TotalComponents(const ImuEffectValues& effects) {
  Eigen::Index n = 0;
  for (const ImuEffectValue& one : effects) n += one.value.size();
  return n;
}

}  // namespace dn
