#pragma once

#include <dn/eigen_alignment.h>
#include <dn/sim/disturbance.h>
#include <dn/sim/dryden.h>
#include <dn/sim/vibration.h>

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace dn {

/// Displacement and rotation of the body by vibration and fast turbulence, with derivatives in
/// closed form. Times are
/// in seconds since the start of the flight. All parts are sums of sinusoids with slowly wandering
/// frequencies.
class PlatformVibration {
 public:
  struct Sample {
    /// Displacement in body axes, m, and its derivatives.
    Eigen::Vector3d shift = Eigen::Vector3d::Zero(), shift_rate = Eigen::Vector3d::Zero(),
                    shift_accel = Eigen::Vector3d::Zero();
    /// Rotation vector from the shaken body to the body, rad, and its derivative.
    Eigen::Vector3d turn = Eigen::Vector3d::Zero(), turn_rate = Eigen::Vector3d::Zero();
  };

  PlatformVibration() = default;  ///< no vibration

  /// Draws phases and wandering frequencies.
  PlatformVibration(const VibrationScenario& scenario, std::uint64_t seed);

  /// Adds the part of the turbulence above DrydenTurbulence::kSplit_hz, as motion along the body's
  /// axes. A stabilised body does not roll or pitch with it.
  void AddTurbulence(const DrydenTurbulence& turbulence, bool stabilised, std::uint64_t seed);

  bool empty() const { return tones_.empty(); }
  /// Returns the highest frequency of all sinusoids; 0 without vibration.
  double highest_hz() const { return highest_hz_; }
  Sample At(double t_s) const;

 private:
  /// Displacement in rows 0..2, rotation in rows 3..5.
  using Vector = Eigen::Matrix<double, 6, 1>;

  /// x = cosine cos(a) + sine sin(a) with a = rate t + share wander(t).
  struct Tone {
    double rate_radps;
    std::size_t wander;
    double wander_share;
    Vector cosine, sine;
  };

  /// Adds a wander of the phase, in rad, with this rms of its rate, and returns its index.
  std::size_t AddWander(double rms_radps, double low_hz, double high_hz, Random& random);
  void AddTone(double frequency_hz, const VibrationLevel& level, std::size_t wander,
               double wander_share, Random& random);
  void AddLine(const VibrationLine& line, Random& random);
  /// Adds tones of equal power to the continuum between the edges.
  void AddContinuum(const std::vector<double>& edges_hz, const VibrationLevel& level,
                    Random& random);
  /// Adds tones with the given levels. Tone i is between edges_hz[i] and edges_hz[i + 1] and
  /// wanders between them.
  void AddTones(const std::vector<double>& edges_hz, const std::vector<VibrationLevel>& levels,
                Random& random);

  std::vector<SumOfSines> wander_rad_;
  std::vector<Tone> tones_;
  double highest_hz_ = 0.0;
};

}  // namespace dn
