#pragma once

#include <dn/imu/imu_data.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Line in the spectrum of a record, such as an engine or a rotor; rms of each axis.
struct ShakingLine {
  double frequency_hz = 0.0;
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accel_mps2 = Eigen::Vector3d::Zero();
};

/// Fast motion of the platform in an inertial record, beyond the white noise of the sensors.
struct Shaking {
  double low_hz = 0.0;                                   ///< only frequencies from here on count
  double high_hz = 0.0;                                  ///< Nyquist frequency
  Eigen::Vector3d rate_radps = Eigen::Vector3d::Zero();  ///< rms of each axis
  Eigen::Vector3d accel_mps2 = Eigen::Vector3d::Zero();  ///< rms of each axis
  double excess = 0.0;  ///< largest power of an axis in units of that of its white noise, minus 1
  std::vector<ShakingLine> lines;  ///< strongest first
  /// Rms of the rotation and of the displacement, for the axis with the largest one. A line above
  /// the Nyquist frequency appears at a lower one, so that this motion can be wrong altogether.
  double turn_rad = 0.0;
  double shift_m = 0.0;
  /// Upper limits of the drift of attitude (coning) and velocity (sculling) by motion that the
  /// samples do not resolve. They hold if all axes are coherent and in quadrature.
  double coning_radps = 0.0;
  double sculling_mps2 = 0.0;

  /// Returns true if the record contains little but white noise.
  bool calm() const;
};

/// Measures the shaking by the mean spectrum of at most 300 parts of the record. The white noise is
/// the lowest level of the spectrum. With x = 2 pi f dt, the samples leave a fraction
///
///   u(x) = |1 - sin(x)/x - (1 - cos(x)) sin(x)/(3x)|
///
/// of the coning at frequency f unresolved, for rates that are linear in time within a sample with
/// the slope from both neighbours. Returns nullopt without three parts of 512 samples at equal
/// intervals, or if the sampling rate is below 20 Hz.
std::optional<Shaking> FindShaking(const ImuData& imu);

/// Describes level, lines and cost on one line.
std::string Describe(const Shaking& shaking);

}  // namespace dn
