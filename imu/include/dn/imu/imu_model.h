#pragma once

#include <string>
#include <vector>

namespace dn {

/// A slowly varying error of one sensor triad, the same model on each of three independent axes.
struct BiasProcess {
  enum class Type { kRandomConstant, kGaussMarkov, kRandomWalk };
  Type type = Type::kRandomConstant;
  /// rad/s (gyro) or m/s^2 (accelerometer); for a random walk per square root of a second:
  /// rad/s/sqrt(s), m/s^2/sqrt(s).
  double sigma = 0.0;
  double tau_s = 0.0;  ///< correlation time, Gauss-Markov only
};

/// White noise and bias processes of a sensor triad.
struct SensorNoise {
  /// rad/s/sqrt(Hz) = rad/sqrt(s) (gyro), m/s^2/sqrt(Hz) = m/s/sqrt(s) (accelerometer). A mean over
  /// dt has standard deviation white / sqrt(dt).
  double white = 0.0;
  std::vector<BiasProcess> processes;
};

/// White noise that every sample has beyond that of the sensors while a vibration lasts.
struct ImuVibration {
  double t0_s = 0.0;  ///< of the time tags of samples; both ends included
  double t1_s = 0.0;
  double gyro_sigma_radps = 0.0;  ///< of a sample, per axis
  double accel_sigma_mps2 = 0.0;

  bool Covers(double t_s) const { return t_s >= t0_s && t_s <= t1_s; }
  bool operator==(const ImuVibration&) const = default;
};

/// The assumed stochastic model of an inertial measurement unit.
struct ImuModel {
  std::string name;
  SensorNoise gyro;
  SensorNoise accel;
  std::vector<ImuVibration> vibration;  ///< where windows overlap, the variances add up
  std::string source;                   ///< where the figures come from
  bool approximate = false;             ///< true when not all figures are the maker's
};

/// Names of the presets: ln200, airins, apx15, imu57, isa100c.
std::vector<std::string> ImuPresetNames();

/// A preset by name; throws InvalidConfig naming the nearest one.
ImuModel ImuPreset(const std::string& name);

/// Discrete Gauss-Markov step over dt: x' = phi x + w, var(w) = q, both exact.
struct GaussMarkovStep {
  double phi = 1.0;
  double q = 0.0;
};
GaussMarkovStep DiscretiseGaussMarkov(double sigma, double tau_s, double dt_s);

/// Unit conversions; the names say it.
double RadpsFromDegPerHour(double deg_h);
double DegPerHourFromRadps(double radps);
double RadPerSqrtSFromDegPerSqrtHour(double deg_sqrt_h);
double Mps2FromMg(double mg);
double MgFromMps2(double mps2);
double MpsPerSqrtSFromMpsPerSqrtHour(double m_s_sqrt_h);
double MpsPerSqrtSFromUgPerSqrtHz(double ug_sqrt_hz);
/// Random-walk densities: deg/h/sqrt(h) -> rad/s/sqrt(s); mg/sqrt(h) -> m/s^2/sqrt(s).
double RadpsPerSqrtSFromDegPerHourPerSqrtHour(double deg_h_sqrt_h);
double Mps2PerSqrtSFromMgPerSqrtHour(double mg_sqrt_h);

/// Throws InvalidConfig when a sigma, density or correlation time is not positive and finite, when a
/// vibration does not begin before it ends, or has a sigma that is negative or not finite.
void Validate(const ImuModel& model);

}  // namespace dn
