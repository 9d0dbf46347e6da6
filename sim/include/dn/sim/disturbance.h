#pragma once

#include <cstdint>
#include <vector>

namespace dn {

class Random;
struct TurbulenceScenario;

/// A sum of sinusoids of incommensurate frequencies: irregular, and differentiable at will.
class SumOfSines {
 public:
  struct Sample {
    double value = 0.0;
    double first = 0.0;   ///< d/dt
    double second = 0.0;  ///< d^2/dt^2
  };

  SumOfSines() = default;  ///< identically zero

  /// `count` waves, log-spaced with jitter between the two frequencies, with amplitudes falling as
  /// 1/sqrt(f) and the given root mean square over a long time.
  SumOfSines(double rms, double f_low_hz, double f_high_hz, int count, Random& random);

  Sample At(double t_s) const;

  /// Sum of the amplitudes: |value| never exceeds it.
  double Bound() const;

  /// Scales so that Bound() <= limit.
  void LimitTo(double limit);

  /// Turns the sum into its integral over time (without a constant).
  void Integrate();

 private:
  struct Wave {
    double amplitude;
    double rate_radps;
    double phase_rad;
  };
  std::vector<Wave> waves_;
};

/// The motion that the air adds to a planned path, seconds since the start of the flight.
struct Disturbance {
  SumOfSines roll_rad;
  SumOfSines pitch_rad;
  SumOfSines heading_rad;
  SumOfSines height_m;
  SumOfSines lead_s;  ///< how far ahead of the plan, in seconds along the path
};

/// mean_speed_mps turns the speed rms into a lead in time. stabilised: roll and pitch are bounded
/// so that the body stays level within 0.3 deg.
Disturbance MakeDisturbance(const TurbulenceScenario& turbulence, double mean_speed_mps,
                            bool stabilised, std::uint64_t seed);

}  // namespace dn
