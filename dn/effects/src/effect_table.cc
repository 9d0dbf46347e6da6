#include <dn/axis_names.h>
#include <dn/effects/effect_table.h>

#include <cassert>
#include <cmath>
#include <cstdio>
#include <numbers>

namespace dn {
namespace {

constexpr double kDeg = std::numbers::pi / 180.0;
constexpr double kDegPerHour = kDeg / 3600.0;
constexpr double kArcsec = kDeg / 3600.0;
constexpr double kStandardGravityMps2 = 9.80665;
constexpr double kMg = 1e-3 * kStandardGravityMps2;
constexpr double kDegPerHourPerG = kDegPerHour / kStandardGravityMps2;
constexpr double kMgal = 1e-5;
constexpr double kMrad = 1e-3;
constexpr double kPpm = 1e-6;
constexpr double kPerKm = 1e-3;

constexpr double kLeastPositive = 1e-12;

struct Limits {
  double lowest, highest;
};
constexpr Limits Within(double most) { return {-most, most}; }
constexpr Limits UpTo(double most) { return {0.0, most}; }
constexpr Limits kRatio{kLeastPositive, 1e6};
constexpr Limits kTau{kLeastPositive, 1e9};

using Components = std::vector<EffectComponent>;

EffectComponent One(const std::string& name, const char* unit, double to_si, double typical,
                    Limits in) {
  return {name, unit, to_si, typical, in.lowest, in.highest};
}

Components Three(const std::vector<std::string>& names, const char* unit, double to_si,
                 double typical, Limits in) {
  Components three;
  for (const std::string& name : names) three.push_back(One(name, unit, to_si, typical, in));
  return three;
}

Components Xyz(const char* unit, double to_si, double typical, Limits in) {
  return Three(AxisNames(kXyz), unit, to_si, typical, in);
}

Components Ratio(double typical) { return {One("ratio", "1", 1.0, typical, kRatio)}; }

Components GaussMarkov(Components sigma, double tau_s) {
  sigma.push_back(One("tau", "s", 1.0, tau_s, kTau));
  return sigma;
}

Components GrossErrors(double share, double size_m) {
  return {One("share", "1", 1.0, share, UpTo(1.0)), One("size", "m", 1.0, size_m, UpTo(1e6))};
}

Components Seconds(double typical) { return {One("offset", "s", 1.0, typical, Within(1e6))}; }

std::vector<EffectSpec> MakeTable() {
  using enum EffectId;
  using enum EffectSensor;
  using enum EffectKind;
  using enum EffectTiming;
  const std::vector<std::string> enu = AxisNames(kEnu);
  const std::vector<std::string> sigma_enu{"sigma east", "sigma north", "sigma up"};
  const Limits scale = Within(5e5);
  const Limits arm = Within(1e3);
  const Limits sigma = UpTo(1e6);
  return {
      {kGnssLeverArm, "gnss_lever_arm", kGnss, kFixed, kFlight, Xyz("m", 1.0, 0.03, arm)},
      {kGnssTimeOffset, "gnss_time_offset", kGnss, kFixed, kFlight, Seconds(5e-4)},
      {kGnssTimeDrift,
       "gnss_time_drift",
       kGnss,
       kFixed,
       kFlight,
       {One("drift", "ppm", kPpm, 2.0, scale)}},
      {kGnssCorrelatedNoise, "gnss_correlated_noise", kGnss, kProcess, kFlight,
       GaussMarkov(Three(sigma_enu, "m", 1.0, 0.02, sigma), 40.0)},
      {kGnssMultipath, "gnss_multipath", kGnss, kProcess, kFlight,
       GaussMarkov(Three(sigma_enu, "m", 1.0, 0.02, sigma), 20.0)},
      {kGnssPositionStep, "gnss_position_step", kGnss, kFixed, kWindow,
       Three(enu, "m", 1.0, 0.02, Within(1e6))},
      {kGnssNoiseScale, "gnss_noise_scale", kGnss, kNoise, kFlight, Ratio(2.0)},
      {kGyroScaleFactor, "gyro_scale_factor", kGyro, kFixed, kFlight,
       Xyz("ppm", kPpm, 200.0, scale)},
      {kAccelScaleFactor, "accel_scale_factor", kAccel, kFixed, kFlight,
       Xyz("ppm", kPpm, 200.0, scale), true},
      {kGyroMisalignment, "gyro_misalignment", kGyro, kFixed, kFlight,
       Xyz("mrad", kMrad, 0.2, Within(3e3))},
      {kAccelMisalignment, "accel_misalignment", kAccel, kFixed, kFlight,
       Xyz("mrad", kMrad, 0.2, Within(3e3)), true},
      {kGyroGSensitivity, "gyro_g_sensitivity", kGyro, kFixed, kFlight,
       Xyz("deg/h/g", kDegPerHourPerG, 1.5, Within(1e6))},
      {kGyroBiasProcess, "gyro_bias_process", kGyro, kProcess, kFlight,
       GaussMarkov({One("sigma", "deg/h", kDegPerHour, 0.3, sigma)}, 100.0)},
      {kAccelBiasProcess, "accel_bias_process", kAccel, kProcess, kFlight,
       GaussMarkov({One("sigma", "mg", kMg, 0.05, sigma)}, 100.0)},
      {kGyroNoiseScale, "gyro_noise_scale", kGyro, kNoise, kFlight, Ratio(1.5)},
      {kAccelNoiseScale, "accel_noise_scale", kAccel, kNoise, kFlight, Ratio(1.5)},
      {kImuVibration,
       "imu_vibration",
       kImu,
       kNoise,
       kWindow,
       {One("sigma gyro", "deg/s", kDeg, 0.1, sigma),
        One("sigma accel", "m/s^2", 1.0, 0.3, sigma)}},
      {kGravityTilt, "gravity_tilt", kAccel, kFixed, kFlight,
       Three({"north", "east"}, "arcsec", kArcsec, 6.0, Within(3.6e4)), true},
      {kGravityDisturbance,
       "gravity_disturbance",
       kAccel,
       kFixed,
       kFlight,
       {One("disturbance", "mGal", kMgal, 20.0, Within(1e5))},
       true},
      {kLidarLeverArm, "lidar_lever_arm", kLidar, kFixed, kFlight, Xyz("m", 1.0, 0.02, arm)},
      {kLidarTimeOffset, "lidar_time_offset", kLidar, kFixed, kFlight, Seconds(2e-4)},
      {kLidarTimeDrift,
       "lidar_time_drift",
       kLidar,
       kFixed,
       kFlight,
       {One("drift", "ppm", kPpm, 0.2, scale)}},
      {kLidarRangeOffset,
       "lidar_range_offset",
       kLidar,
       kFixed,
       kFlight,
       {One("offset", "m", 1.0, 0.02, arm)}},
      {kLidarRangeScale,
       "lidar_range_scale",
       kLidar,
       kFixed,
       kFlight,
       {One("scale", "ppm", kPpm, 50.0, scale)}},
      {kLidarAngleScale,
       "lidar_angle_scale",
       kLidar,
       kFixed,
       kFlight,
       {One("scale", "ppm", kPpm, 300.0, scale)}},
      {kLidarScanCone,
       "lidar_scan_cone",
       kLidar,
       kFixed,
       kFlight,
       {One("angle", "deg", kDeg, 0.02, Within(45.0))}},
      {kLidarScanTorsion,
       "lidar_scan_torsion",
       kLidar,
       kFixed,
       kFlight,
       {One("amplitude", "deg", kDeg, 0.005, Within(45.0))}},
      {kBoresightDrift, "boresight_drift", kLidar, kFixed, kFlight,
       Xyz("deg/h", kDegPerHour, 0.01, Within(360.0))},
      {kBoresightStep, "boresight_step", kLidar, kFixed, kStart,
       Xyz("deg", kDeg, 0.003, Within(90.0))},
      {kP2pNoiseScale, "p2p_noise_scale", kPairs, kNoise, kFlight, Ratio(1.5)},
      {kP2pOutliers, "p2p_outliers", kPairs, kOutliers, kFlight, GrossErrors(0.03, 1.0)},
      {kP2pRangeNoise,
       "p2p_range_noise",
       kPairs,
       kNoise,
       kFlight,
       {One("sigma per range", "m/km", kPerKm, 0.05, sigma)}},
      {kTrajectoryAttitudeOffset, "trajectory_attitude_offset", kTrajectory, kFault, kFlight,
       Xyz("deg", kDeg, 0.1, Within(180.0))},
      {kGnssOutage, "gnss_outage", kGnss, kFault, kWindow, {}},
      {kGnssOutliers, "gnss_outliers", kGnss, kOutliers, kFlight, GrossErrors(0.01, 0.3)},
      {kGnssClockStep, "gnss_clock_step", kGnss, kFault, kStart, Seconds(0.1)},
      {kImuGap, "imu_gap", kImu, kFault, kWindow, {}},
      {kImuClockStep, "imu_clock_step", kImu, kFault, kStart, Seconds(0.1)},
  };
}

std::string Short(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

std::string CountFault(const EffectSpec& effect) {
  const std::size_t count = effect.components.size();
  if (count == 0) return "'" + effect.name + "' takes no value";
  std::string text = "'" + effect.name + "' takes " + std::to_string(count) +
                     (count == 1 ? " number (" : " numbers (");
  for (std::size_t i = 0; i < count; ++i) {
    const EffectComponent& part = effect.components[i];
    text += (i == 0 ? "" : ", ") + part.name + " [" + part.unit + "]";
  }
  return text + ")";
}

std::string BoundFault(const EffectComponent& part, double value) {
  const std::string is = ", is " + Short(value);
  if (value < part.lowest && part.lowest == kLeastPositive) {
    return part.name + " must be positive" + is;
  }
  if (value < part.lowest && part.lowest == 0.0) return part.name + " must not be negative" + is;
  return part.name + " must lie between " + Short(part.lowest) + " and " + Short(part.highest) +
         (part.unit == "1" ? "" : " " + part.unit) + is;
}

}  // namespace

const std::vector<EffectSpec>& EffectTable() {
  static const std::vector<EffectSpec> table = MakeTable();
  return table;
}

const EffectSpec& EffectRow(EffectId id) {
  const EffectSpec& row = EffectTable()[static_cast<std::size_t>(id)];
  assert(row.id == id);
  return row;
}

const std::string& EffectName(EffectId id) { return EffectRow(id).name; }

bool IsEffect(std::string_view name, EffectId id) { return name == EffectName(id); }

const EffectSpec* FindEffect(std::string_view name) {
  const std::string_view effect_name = name.substr(0, name.find('/'));
  for (const EffectSpec& effect : EffectTable()) {
    if (effect.name == effect_name) return &effect;
  }
  return nullptr;
}

std::vector<std::string> EffectNames(std::optional<EffectKind> kind) {
  std::vector<std::string> names;
  for (const EffectSpec& effect : EffectTable()) {
    if (!kind || effect.kind == *kind) names.push_back(effect.name);
  }
  return names;
}

std::string TimingKey(EffectTiming timing) {
  switch (timing) {
    case EffectTiming::kWindow:
      return "window_s";
    case EffectTiming::kStart:
      return "t0_s";
    case EffectTiming::kFlight:
      break;
  }
  return {};
}

std::optional<std::string> ValueFault(const EffectSpec& effect, const std::vector<double>& value) {
  if (value.size() != effect.components.size()) return CountFault(effect);
  for (std::size_t i = 0; i < value.size(); ++i) {
    const EffectComponent& part = effect.components[i];
    if (!(value[i] >= part.lowest && value[i] <= part.highest)) return BoundFault(part, value[i]);
  }
  return std::nullopt;
}

Eigen::VectorXd ValueInSi(const EffectSpec& effect, const std::vector<double>& value) {
  assert(value.size() == effect.components.size());
  Eigen::VectorXd si(static_cast<Eigen::Index>(value.size()));
  for (std::size_t i = 0; i < value.size(); ++i) {
    si[static_cast<Eigen::Index>(i)] = effect.components[i].to_si * value[i];
  }
  return si;
}

Eigen::VectorXd TypicalInSi(const EffectSpec& effect) {
  Eigen::VectorXd si(static_cast<Eigen::Index>(effect.components.size()));
  for (std::size_t i = 0; i < effect.components.size(); ++i) {
    si[static_cast<Eigen::Index>(i)] = effect.components[i].typical_si();
  }
  return si;
}

}  // namespace dn
