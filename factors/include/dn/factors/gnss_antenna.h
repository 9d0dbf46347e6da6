#pragma once

#include <dn/block.h>
#include <dn/factor.h>
#include <dn/noise.h>

#include <Eigen/Core>
#include <memory>
#include <utility>
#include <vector>

namespace dn {

/// What a file says of one GNSS epoch on its way to what is true, with the derivatives that it
/// carries.
struct GnssReading {
  double tag_s = 0.0;                                 ///< time tag of the file
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< measured = true + shift, map axes
  double delay_s = 0.0;                               ///< the epoch is tag - delay
  Eigen::Matrix3Xd J_shift;                           ///< with respect to the values of all effects
  Eigen::RowVectorXd J_delay;
};

/// A constant error of the GNSS positions or of their tags.
class GnssEffect {
 public:
  virtual ~GnssEffect() = default;

  /// Number of values.
  virtual int components() const = 0;

  /// Adds what the value does to the reading, and its derivatives to the columns from `column` on,
  /// which are zero on entry.
  virtual void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
                       GnssReading* reading) const = 0;
};

using GnssEffects = std::vector<std::shared_ptr<const GnssEffect>>;

/// What all effects together make of the tag, with one pointer to the values of each.
GnssReading Corrected(const GnssEffects& effects, double const* const* values, double tag_s);

/// How the body moves at a node near the tag of an epoch: the antenna's way from the node to the
/// epoch is that of constant rate and acceleration.
struct MotionAtTag {
  double tag_s = 0.0;
  Eigen::Vector3d w_ib_b_radps = Eigen::Vector3d::Zero();  ///< corrected angular rate
  Eigen::Vector3d w_ie_m_radps = Eigen::Vector3d::Zero();  ///< Earth rotation in map
  Eigen::Vector3d a_m_mps2 = Eigen::Vector3d::Zero();      ///< d v_m / dt of the body origin
  double node_lead_s = 0.0;                                ///< the node stands at tag - lead
};

/// GNSS antenna position or velocity at a tag that may be late, with calibration values among its
/// blocks. With d the delay of the tag less the lead of the node, w = w_ib_b - R_mb^T w_ie_m and
/// R(d) = R_mb Exp(-d w),
///
///   position  r = W (p_mb - d v_m + d^2/2 a_m + R(d) a_b + shift - z)       [3], unitless
///   velocity  r = W (v_m - d a_m + R(d) (w x a_b) - z)
///
///   block | symbol | stored | tangent | meaning
///   ------|--------|--------|---------|---------------------------------------------------
///     0   | q_mb   |   4    |    3    | rotation body -> map at the node, (x, y, z, w)
///     1   | p_mb   |   3    |    3    | body origin in map at the node, m; has no part in a
///     velocity 2   | v_m    |   3    |    3    | its velocity in map, m/s 3   | a_b    |   3    |
///     3    | antenna phase centre in body, m
///    then | c      |   n    |    n    | one per effect, SI
///
/// Jacobians are analytic; the tangent of block 0 is right, rad. Accuracy: what the acceleration
/// changes by over d, below 1e-6 m at 10 ms and 5 m/s^3. Degenerate when: as GnssPosition
/// and GnssVelocity; at constant velocity and attitude a delay is not separable from a lever arm.
class GnssAntenna final : public DynamicFactor {
 public:
  enum class Quantity { kPosition, kVelocity };

  /// z_m: measured position (m) or velocity (m/s) in map; noise: in map axes. Throws InvalidInput
  /// if not finite.
  GnssAntenna(Quantity quantity, const Eigen::Vector3d& z_m, const MotionAtTag& motion,
              GnssEffects effects, const Noise<3>& noise);

  bool Evaluate(double const* const* x, double* r, double** J) const override;

 private:
  Quantity quantity_;
  Eigen::Vector3d z_m_;
  MotionAtTag motion_;
  GnssEffects effects_;
  Eigen::Matrix3d W_;
};

}  // namespace dn
