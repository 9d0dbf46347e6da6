#pragma once

#include <dn/imu/imu_data.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

namespace dn {

/// Relation of two inertial units a and b on one rigid body, from their angular rates:
///
///   w_b(t + offset + drift (t - first)) = R_ba w_a(t) + bias + noise,
///
/// where t are the tags of a, and `first` is the beginning of the common span in these tags.
struct UnitAgreement {
  double offset_s = 0.0;  ///< tag of b minus tag of a at `first`
  double sigma_offset_s = 0.0;
  double drift = 0.0;  ///< seconds per second
  double sigma_drift = 0.0;
  Eigen::Quaterniond q_ba = Eigen::Quaterniond::Identity();      ///< axes of a -> axes of b
  Eigen::Vector3d sigma_rotation_rad = Eigen::Vector3d::Zero();  ///< axes of b
  double first_s = 0.0;  ///< begin of the common span, tags of a
  double last_s = 0.0;   ///< its end
  /// Means over bins of a tenth of a second, or of a row if rows are longer: rms of the differences
  /// of the rates, and of the rates of a without their mean. Both are per axis.
  double noise_radps = 0.0, motion_radps = 0.0;
  /// Squared differences of the solutions of eight parts of the span from the whole one, divided by
  /// their variances. Near 1 if the units agree within their noise. The sigmas above are those of
  /// the noise, multiplied by the root of it if it exceeds 1.
  double variance_ratio = 0.0;
  double p_value = 1.0;  ///< probability of such a ratio or a larger one if the units agree
};

/// Finds the relation of two units whose clocks are independent of each other. If one of them has
/// few rows or much noise, it must be b. The magnitudes of
/// the rates, which do not depend on axes, give the offset; least squares over the rates give the
/// rest. Returns nullopt if the units do not measure the same rotations during 20 s at least, or
/// during 200 rows of the slower unit. Also returns nullopt if two offsets fit about as well, or if
/// the body turns about one axis only.
std::optional<UnitAgreement> CompareUnits(const ImuData& a, const ImuData& b);

}  // namespace dn
