#pragma once

#include <dn/sim/dryden.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace dn {

class Random;
struct TurbulenceScenario;

/// Sum of sinusoids with incommensurate frequencies: irregular, with derivatives of any order.
class SumOfSines {
 public:
  struct Sample {
    double value = 0.0;
    double first = 0.0;   ///< d/dt
    double second = 0.0;  ///< d^2/dt^2
  };

  SumOfSines() = default;  ///< zero at all times

  /// Creates `count` waves between the two frequencies, log-spaced with jitter. `amplitude` gives
  /// their relative amplitudes; the root mean square over a long time is `rms`.
  SumOfSines(double rms, double f_low_hz, double f_high_hz, int count, Random& random,
             const std::function<double(double f_hz)>& amplitude = FallingAmplitude);

  /// Returns 1/sqrt(f).
  static double FallingAmplitude(double f_hz);

  /// Returns the sum and its first two derivatives at a time.
  Sample At(double t_s) const;

  /// Returns the sum of the amplitudes: |value| never exceeds it.
  double Bound() const;

  /// Reduces the amplitudes if necessary so that Bound() <= limit.
  void LimitTo(double limit);

  /// Replaces the sum by its integral over time (without a constant).
  void Integrate();

 private:
  struct Wave {
    double amplitude;
    double rate_radps;
    double phase_rad;
  };
  std::vector<Wave> waves_;
};

/// Motion that turbulence adds to a planned path, as functions of the time in seconds since the
/// start of the flight.
struct Disturbance {
  SumOfSines roll_rad;
  SumOfSines pitch_rad;
  SumOfSines heading_rad;
  SumOfSines height_m;
  SumOfSines lead_s;  ///< time ahead of the plan, in seconds along the path
};

/// Draws a disturbance of up to 1 Hz. mean_speed_mps converts the rms of the speed to a lead in
/// time. stabilised: limits roll and pitch so that the body stays level within 0.3 deg. With
/// `dryden`, the result is the part of this turbulence below DrydenTurbulence::kSplit_hz.
Disturbance MakeDisturbance(const TurbulenceScenario& turbulence, double mean_speed_mps,
                            bool stabilised, std::uint64_t seed,
                            const DrydenTurbulence* dryden = nullptr);

}  // namespace dn
