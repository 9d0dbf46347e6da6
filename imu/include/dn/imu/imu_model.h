#pragma once

#include <string>
#include <vector>

namespace dn {

/// Slowly varying error of one sensor triad. The three axes are independent and have the same
/// model.
struct BiasProcess {
  enum class Type { kRandomConstant, kGaussMarkov, kRandomWalk };
  Type type = Type::kRandomConstant;
  /// Standard deviation, rad/s (gyro) or m/s^2 (accelerometer). For a random walk it is per square
  /// root of a second: rad/s/sqrt(s), m/s^2/sqrt(s).
  double sigma = 0.0;
  double tau_s = 0.0;  ///< correlation time; only for Gauss-Markov
};

/// White noise and bias processes of a sensor triad.
struct SensorNoise {
  /// White noise density, rad/s/sqrt(Hz) = rad/sqrt(s) (gyro) or m/s^2/sqrt(Hz) = m/s/sqrt(s)
  /// (accelerometer). A mean over dt has standard deviation white / sqrt(dt).
  double white = 0.0;
  std::vector<BiasProcess> processes;
};

/// White noise that vibration adds to every sample during an interval.
struct ImuVibration {
  double t0_s = 0.0;  ///< first time tag of the vibration; both ends are included
  double t1_s = 0.0;
  double gyro_sigma_radps = 0.0;  ///< sigma of one sample, per axis
  double accel_sigma_mps2 = 0.0;

  bool Covers(double t_s) const { return t_s >= t0_s && t_s <= t1_s; }
  bool operator==(const ImuVibration&) const = default;
};

/// Assumed stochastic model of an inertial measurement unit.
struct ImuModel {
  std::string name;
  SensorNoise gyro;
  SensorNoise accel;
  std::vector<ImuVibration> vibration;  ///< variances add up where windows overlap
  std::string source;                   ///< source of the figures
  bool approximate = false;             ///< true if some of the figures are not the manufacturer's
};

/// Returns the names of the presets: ln200, airins, apx15, imu57, isa100c.
std::vector<std::string> ImuPresetNames();

/// Returns a preset by name. Throws InvalidConfig with the nearest name if there is no such preset.
ImuModel ImuPreset(const std::string& name);

/// Discrete Gauss-Markov step over dt: x' = phi x + w, var(w) = q; both are exact.
struct GaussMarkovStep {
  double phi = 1.0;
  double q = 0.0;
};
/// Returns the exact step over dt_s of a process with standard deviation `sigma` and correlation
/// time tau_s.
GaussMarkovStep DiscretiseGaussMarkov(double sigma, double tau_s, double dt_s);

/// The functions below convert between units according to their names.
double RadpsFromDegPerHour(double deg_h);
double DegPerHourFromRadps(double radps);
double RadPerSqrtSFromDegPerSqrtHour(double deg_sqrt_h);
double Mps2FromMg(double mg);
double MgFromMps2(double mps2);
double MpsPerSqrtSFromMpsPerSqrtHour(double m_s_sqrt_h);
double MpsPerSqrtSFromUgPerSqrtHz(double ug_sqrt_hz);
/// These two functions convert random-walk densities: deg/h/sqrt(h) to rad/s/sqrt(s), and
/// mg/sqrt(h) to m/s^2/sqrt(s).
double RadpsPerSqrtSFromDegPerHourPerSqrtHour(double deg_h_sqrt_h);
double Mps2PerSqrtSFromMgPerSqrtHour(double mg_sqrt_h);

/// Throws InvalidConfig if a sigma, density or correlation time is not positive and finite. Throws
/// InvalidConfig also if a vibration does not begin before it ends, or its sigma is negative or not
/// finite.
void Validate(const ImuModel& model);

}  // namespace dn
