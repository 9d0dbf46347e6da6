#pragma once

#include <array>

namespace dn {

struct TurbulenceScenario;

/// Motions that turbulence adds to the planned one.
enum class GustMotion { kRoll, kPitch, kHeading, kSpeed, kHeight };

/// Gusts of the Dryden model around an aircraft, and the motion of a body that follows them.
///
/// With the angular frequency w, a = w/V and the span b, the spectra of the gusts along and upward,
/// and of the rates about roll, pitch and heading are
///
///   S_u ~ 1 / (1 + (L_u a)^2)
///   S_w ~ (1 + 3 (L_w a)^2) / (1 + (L_w a)^2)^2
///   S_p ~ 1 / (1 + (4 b a / pi)^2)
///   S_q ~ a^2 S_w / (1 + (4 b a / pi)^2)
///   S_r ~ a^2 S_v / (1 + (3 b a / pi)^2),   S_v as S_w with L_u
///
/// The body turns with these rates. It moves with the mean of the gusts over the span, which has
/// the factor of S_q, so that its accelerations are finite. Their sizes are free.
///
/// Source: MIL-F-8785C, Flying qualities of piloted airplanes, 3.7.1.2 (spectra), 3.7.2 and 3.7.3
/// (scale lengths).
struct DrydenGusts {
  double airspeed_mps = 0.0;      ///< V
  double wingspan_m = 0.0;        ///< b
  double scale_m = 0.0;           ///< L_u = L_v
  double vertical_scale_m = 0.0;  ///< L_w

  /// Returns gusts with the scale lengths of a height above the ground. They are constant above
  /// 2000 ft, those of low altitude below 1000 ft, and interpolated between.
  static DrydenGusts At(double height_m, double airspeed_mps, double wingspan_m);

  /// Returns the relative spectral density of a motion at a frequency > 0: an angle, the speed
  /// along the path, or the height.
  double Density(GustMotion motion, double f_hz) const;

  /// Returns the integral of Density.
  double Power(GustMotion motion, double f_low_hz, double f_high_hz) const;
};

/// Motion by gusts with the sizes of a scenario, up to a highest frequency. The parts below and
/// above kSplit_hz are simulated in different ways.
class DrydenTurbulence {
 public:
  static constexpr double kSplit_hz = 1.0;

  /// `turbulence` gives the root mean squares over all frequencies.
  DrydenTurbulence(const TurbulenceScenario& turbulence, const DrydenGusts& gusts, double top_hz);

  const DrydenGusts& gusts() const { return gusts_; }
  double top_hz() const { return top_hz_; }

  /// Returns the root mean square of the part of a motion between two frequencies. It is an angle
  /// in rad, the speed in m/s, or the height in m.
  double Rms(GustMotion motion, double f_low_hz, double f_high_hz) const;

  /// Returns the lowest frequency of a motion: 0.02 Hz for an angle, 0.005 Hz for speed and height.
  /// An aircraft is kept on its path and course.
  static double LowestHz(GustMotion motion);

 private:
  std::array<double, 5> rms_;  // in the order of GustMotion
  DrydenGusts gusts_;
  double top_hz_;
};

}  // namespace dn
