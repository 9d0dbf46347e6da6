#pragma once

#include <dn/block.h>
#include <dn/factor.h>
#include <dn/noise.h>

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

namespace dn {

/// One GNSS epoch of a file with the corrections of all effects, and their derivatives.
struct GnssReading {
  double tag_s = 0.0;                                 ///< time tag in the file
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< measured = true + shift, map axes
  double delay_s = 0.0;                               ///< true epoch = tag - delay
  Eigen::Vector3d arm_b_m = Eigen::Vector3d::Zero();  ///< added to the lever arm
  /// Derivatives with respect to the values of all effects, in their order.
  Eigen::Matrix3Xd J_shift, J_arm;
  Eigen::RowVectorXd J_delay;

  /// Returns a reading without corrections, with zero derivatives for `columns` values.
  static GnssReading Uncorrected(double tag_s, Eigen::Index columns) {
    GnssReading reading;
    reading.tag_s = tag_s;
    reading.J_shift.setZero(3, columns);
    reading.J_arm.setZero(3, columns);
    reading.J_delay.setZero(columns);
    return reading;
  }
};

/// A constant error of the GNSS positions, of their time tags or of the lever arm.
class GnssEffect {
 public:
  virtual ~GnssEffect() = default;

  /// Returns the number of values.
  virtual int components() const = 0;

  /// Adds the correction by `value` to the reading. Also adds its derivatives to the columns from
  /// `column` on, which are zero on entry.
  virtual void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
                       GnssReading* reading) const = 0;
};

using GnssEffects = std::vector<std::shared_ptr<const GnssEffect>>;

/// Returns the reading at the time tag tag_s with the corrections of all effects. `values` has one
/// pointer to the values of each effect.
GnssReading Corrected(const GnssEffects& effects, double const* const* values, double tag_s);

/// Motion of the body at a node near the tag of an epoch. Between the node and the epoch the
/// angular rate and the acceleration of the antenna are taken as constant.
struct MotionNearTag {
  double tag_s = 0.0;
  Eigen::Vector3d w_ib_b_radps = Eigen::Vector3d::Zero();  ///< corrected angular rate
  Eigen::Vector3d w_ie_m_radps = Eigen::Vector3d::Zero();  ///< Earth rotation in map
  Eigen::Vector3d a_m_mps2 = Eigen::Vector3d::Zero();      ///< d v_m / dt of the body origin
  double node_lead_s = 0.0;                                ///< node time = tag - lead
};

/// GNSS antenna position or velocity at a tag that may be delayed, with calibration values among
/// its blocks. With d the delay of the tag minus the lead of the node, w = w_ib_b - R_mb^T w_ie_m
/// and R(d) = R_mb Exp(-d w), and with a = a_b plus the correction of the lever arm:
///
///   position  r = W (p_mb - d v_m + d^2/2 a_m + R(d) a + shift - z)         [3], unitless
///   velocity  r = W (v_m - d a_m + R(d) (w x a) - z)
///
///   block | symbol | stored | tangent | meaning
///   ------|--------|--------|---------|---------------------------------------------------
///     0   | q_mb   |   4    |    3    | rotation body -> map at the node, (x, y, z, w)
///     1   | p_mb   |   3    |    3    | body origin in map at the node, m; unused by a velocity
///     2   | a_b    |   3    |    3    | antenna phase centre in body, m
///     3   | v_m    |   3    |    3    | velocity of the body origin in map at the node, m/s
///    then | c      |   n    |    n    | one per effect, SI
///
/// Jacobians are analytic; the tangent of block 0 is right, rad. Accuracy: the neglected change of
/// the acceleration over d is below 1e-6 m at 10 ms and 5 m/s^3. Degenerate when: as GnssPosition
/// and GnssVelocity; at constant velocity and attitude a delay is not separable from a lever arm.
class GnssAntenna final : public DynamicFactor {
 public:
  enum class Quantity { kPosition, kVelocity };

  /// Creates the factor; z_m is the measured position (m) or velocity (m/s) in map, and `noise` is
  /// in map axes. Throws InvalidInput if a value is not finite.
  GnssAntenna(Quantity quantity, const Eigen::Vector3d& z_m, const MotionNearTag& motion,
              GnssEffects effects, const Noise<3>& noise);

  bool Evaluate(double const* const* x, double* r, double** J) const override;

 private:
  Quantity quantity_;
  Eigen::Vector3d z_m_;
  MotionNearTag motion_;
  GnssEffects effects_;
  Eigen::Matrix3d W_;
};

}  // namespace dn
