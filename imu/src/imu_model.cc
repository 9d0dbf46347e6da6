#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/imu/imu_model.h>
#include <dn/imu/unknown_imu.h>
#include <dn/names.h>

#include <cmath>
#include <string>
#include <vector>

namespace dn {
namespace {

constexpr double kSecondsPerHour = 3600.0;
constexpr double kSqrtSecondsPerSqrtHour = 60.0;

/// Figures of a preset in the units of data sheets.
struct Datasheet {
  const char* name;
  double gyro_constant_deg_h, gyro_markov_deg_h, gyro_tau_s, gyro_white_deg_sqrt_h;
  double accel_constant_ug, accel_markov_ug, accel_tau_s, accel_white_ug_sqrt_hz;
  const char* source;
};

constexpr Datasheet kDatasheets[] = {
    {"ln200", 1.0, 0.35, 100.0, 0.07, 300.0, 50.0, 60.0, 50.0,
     "Northrop Grumman LN-200 data sheet, figures from memory, not checked against an edition"},
    {"airins", 0.01, 0.003, 3600.0, 0.002, 50.0, 10.0, 3600.0, 10.0,
     "navigation-grade fibre-optic class (IXblue AIRINS): gyro constant and white noise of the "
     "class; in-run figures and accelerometers are estimates"},
    {"apx15", 30.0, 8.0, 600.0, 0.2, 3000.0, 300.0, 600.0, 80.0,
     "Applanix APX-15 UAV: the maker publishes no sensor figures; an estimate of the MEMS class "
     "that matches its post-processed attitude of 0.025 and 0.080 deg"},
    {"imu57", 0.01, 0.003, 3600.0, 0.005, 50.0, 15.0, 3600.0, 20.0,
     "Applanix POS AV 610 (IMU-57): gyro from the data sheet, from memory; accelerometers are "
     "estimates"},
    {"isa100c", 0.5, 0.05, 1000.0, 0.012, 1250.0, 100.0, 1000.0, 100.0,
     "Northrop Grumman Litef ISA-100C data sheet, figures from memory; correlation times are "
     "estimates"},
};

ImuModel MakeModel(const Datasheet& sheet) {
  using Type = BiasProcess::Type;
  ImuModel model;
  model.name = sheet.name;
  model.gyro.white = RadPerSqrtSFromDegPerSqrtHour(sheet.gyro_white_deg_sqrt_h);
  model.gyro.processes = {
      {Type::kRandomConstant, RadpsFromDegPerHour(sheet.gyro_constant_deg_h), 0.0},
      {Type::kGaussMarkov, RadpsFromDegPerHour(sheet.gyro_markov_deg_h), sheet.gyro_tau_s}};
  model.accel.white = MpsPerSqrtSFromUgPerSqrtHz(sheet.accel_white_ug_sqrt_hz);
  model.accel.processes = {
      {Type::kRandomConstant, Mps2FromMg(1e-3 * sheet.accel_constant_ug), 0.0},
      {Type::kGaussMarkov, Mps2FromMg(1e-3 * sheet.accel_markov_ug), sheet.accel_tau_s}};
  model.source = sheet.source;
  model.approximate = true;  // no preset has all its figures from a cited edition of a data sheet
  return model;
}

void CheckPositive(double value, const std::string& what) {
  if (!(value > 0.0) || !std::isfinite(value)) {
    throw InvalidConfig(what + " is " + std::to_string(value) +
                        ", but must be positive and finite");
  }
}

void CheckSensor(const SensorNoise& noise, const std::string& sensor) {
  CheckPositive(noise.white, sensor + ": white noise");
  for (std::size_t i = 0; i < noise.processes.size(); ++i) {
    const BiasProcess& process = noise.processes[i];
    const std::string which = sensor + ": bias process " + std::to_string(i + 1);
    CheckPositive(process.sigma, which + ": sigma");
    if (process.type == BiasProcess::Type::kGaussMarkov) {
      CheckPositive(process.tau_s, which + ": tau_s");
    }
  }
}

void CheckVibration(const ImuVibration& vibration, const std::string& which) {
  if (!(vibration.t0_s < vibration.t1_s)) {
    throw InvalidConfig(which + ": the window from " + std::to_string(vibration.t0_s) + " s to " +
                        std::to_string(vibration.t1_s) + " s must begin before it ends");
  }
  for (const double sigma : {vibration.gyro_sigma_radps, vibration.accel_sigma_mps2}) {
    if (sigma >= 0.0 && std::isfinite(sigma)) continue;
    throw InvalidConfig(which + ": a sigma is " + std::to_string(sigma) +
                        ", but must be finite and at least 0");
  }
}

}  // namespace

std::vector<std::string> ImuPresetNames() {
  std::vector<std::string> names;
  for (const Datasheet& sheet : kDatasheets) names.emplace_back(sheet.name);
  return names;
}

ImuModel ImuPreset(const std::string& name) {
  for (const Datasheet& sheet : kDatasheets) {
    if (name == sheet.name) return MakeModel(sheet);
  }
  throw InvalidConfig("imu: there is no grade '" + name + "'; did you mean '" +
                      NearestName(name, ImuPresetNames()) + "'?");
}

ImuModel UnknownImu() {
  return MakeModel({kUnknownGrade, 1000.0, 50.0, 300.0, 0.3, 50000.0, 1000.0, 300.0, 300.0,
                    "start of an estimation from the data"});
}

GaussMarkovStep DiscretiseGaussMarkov(double sigma, double tau_s, double dt_s) {
  return {std::exp(-dt_s / tau_s), -sigma * sigma * std::expm1(-2.0 * dt_s / tau_s)};
}

double RadpsFromDegPerHour(double deg_h) { return deg_h * kRadPerDeg / kSecondsPerHour; }
double DegPerHourFromRadps(double radps) { return radps / kRadPerDeg * kSecondsPerHour; }
double RadPerSqrtSFromDegPerSqrtHour(double deg_sqrt_h) {
  return deg_sqrt_h * kRadPerDeg / kSqrtSecondsPerSqrtHour;
}
double Mps2FromMg(double mg) { return mg * 1e-3 * kStandardGravityMps2; }
double MgFromMps2(double mps2) { return mps2 * 1e3 / kStandardGravityMps2; }
double MpsPerSqrtSFromMpsPerSqrtHour(double m_s_sqrt_h) {
  return m_s_sqrt_h / kSqrtSecondsPerSqrtHour;
}
double MpsPerSqrtSFromUgPerSqrtHz(double ug_sqrt_hz) {
  return ug_sqrt_hz * 1e-6 * kStandardGravityMps2;
}
double RadpsPerSqrtSFromDegPerHourPerSqrtHour(double deg_h_sqrt_h) {
  return RadpsFromDegPerHour(deg_h_sqrt_h) / kSqrtSecondsPerSqrtHour;
}
double Mps2PerSqrtSFromMgPerSqrtHour(double mg_sqrt_h) {
  return Mps2FromMg(mg_sqrt_h) / kSqrtSecondsPerSqrtHour;
}

void Validate(const ImuModel& model) {
  CheckSensor(model.gyro, "imu.gyro");
  CheckSensor(model.accel, "imu.accel");
  for (std::size_t i = 0; i < model.vibration.size(); ++i) {
    CheckVibration(model.vibration[i], "imu.vibration " + std::to_string(i + 1));
  }
}

}  // namespace dn
