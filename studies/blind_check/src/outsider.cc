#include <dn/blind_check/described_physics.h>
#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/report/json_numbers.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "random_walk.h"
#include "scan_angle.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kDegPerHour = kRadPerDeg / 3600.0;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

double Sized(double usual, Random& random) { return usual * LogUniform(1.0, 10.0, random); }

/// Returns the size or its negative at random.
double EitherSign(double size, Random& random) { return random.Uniform() < 0.5 ? -size : size; }

double FirstLidarTag(const FlightTimes& times) { return times.strips.front().t0_s; }
double LastLidarTag(const FlightTimes& times) { return times.strips.back().t1_s; }

// The mirror deviates from its plane by a harmonic of the scan angle. The first three look almost
// like a boresight yaw or a conical scan, and the fourth is lidar_scan_torsion.
Json DrawScanTorsion(const FlightTimes&, Random& random) {
  return {{"amplitude_deg", Sized(0.01, random)},
          {"harmonic", 5 + DrawIndex(4, random)},
          {"phase_rad", random.Uniform(0.0, kTwoPi)}};
}

OwnErrors ScanTorsion(const Json& p, const Scenario& scenario) {
  const ScanAxes axes(scenario);
  const double amplitude_rad = kRadPerDeg * p.at("amplitude_deg").get<double>();
  const double harmonic = p.at("harmonic"), phase_rad = p.at("phase_rad");
  OwnErrors own;
  own.laser_vector = [=](const Vector3d& u_s, double) {
    const double forward_rad = amplitude_rad * std::sin(harmonic * axes.Angle(u_s) + phase_rad);
    return Vector3d(u_s + u_s.norm() * forward_rad * axes.axis_s);
  };
  return own;
}

Json DrawStripRangeJump(const FlightTimes& times, Random& random) {
  const StripInterval& strip = times.strips[DrawIndex(times.strips.size(), random)];
  return {{"offset_m", EitherSign(Sized(0.02, random), random)},
          {"window_s", {strip.t0_s, strip.t1_s}}};
}

OwnErrors StripRangeJump(const Json& p, const Scenario&) {
  const double offset_m = p.at("offset_m");
  const EffectTimes times{std::pair<double, double>(p.at("window_s").at(0), p.at("window_s").at(1)),
                          std::nullopt};
  OwnErrors own;
  own.laser_vector = [=](const Vector3d& u_s, double t_s) {
    return times.During(t_s) ? Vector3d((1.0 + offset_m / u_s.norm()) * u_s) : u_s;
  };
  return own;
}

Json DrawGyroOscillation(const FlightTimes&, Random& random) {
  return {{"amplitude_deg_h", DrawAxes(3, Sized(0.5, random), random)},
          {"period_s", LogUniform(20.0, 300.0, random)},
          {"phase_rad", random.Uniform(0.0, kTwoPi)}};
}

OwnErrors GyroOscillation(const Json& p, const Scenario&) {
  const Vector3d amplitude_radps = kDegPerHour * Vector3FromJson(p.at("amplitude_deg_h"));
  const double rate_radps = kTwoPi / p.at("period_s").get<double>();
  const double phase_rad = p.at("phase_rad");
  OwnErrors own;
  own.gyro_radps = [=](double t_s) {
    return Vector3d(std::sin(rate_radps * t_s + phase_rad) * amplitude_radps);
  };
  return own;
}

struct Wave {
  Vector3d amplitude_enu_m;
  double rate_radps, phase_rad;
};

Json DrawGnssWaves(const FlightTimes&, Random& random) {
  constexpr int kWaves = 3;
  const double size_m = Sized(0.02, random) / std::sqrt(static_cast<double>(kWaves));
  Json waves = Json::array();
  for (int i = 0; i < kWaves; ++i) {
    waves.push_back({{"amplitude_enu_m", DrawAxes(3, size_m, random)},
                     {"period_s", LogUniform(20.0, 400.0, random)},
                     {"phase_rad", random.Uniform(0.0, kTwoPi)}});
  }
  return {{"waves", waves}};
}

OwnErrors GnssWaves(const Json& p, const Scenario&) {
  std::vector<Wave> waves;
  for (const Json& wave : p.at("waves")) {
    waves.push_back({Vector3FromJson(wave.at("amplitude_enu_m")),
                     kTwoPi / wave.at("period_s").get<double>(), wave.at("phase_rad")});
  }
  OwnErrors own;
  own.antenna_enu_m = [waves](double t_s) {
    Vector3d sum_m = Vector3d::Zero();
    for (const Wave& wave : waves) {
      sum_m += std::sin(wave.rate_radps * t_s + wave.phase_rad) * wave.amplitude_enu_m;
    }
    return sum_m;
  };
  return own;
}

Json DrawBoresightWarming(const FlightTimes& times, Random& random) {
  const double begin_s = FirstLidarTag(times), end_s = LastLidarTag(times);
  return {{"amplitude_deg", DrawAxes(3, Sized(0.005, random), random)},
          {"tau_s", LogUniform(0.08, 0.4, random) * (end_s - begin_s)},
          {"begin_s", begin_s},
          {"middle_s", 0.5 * (begin_s + end_s)}};
}

// The error is zero in the middle of the strips, as for the effect boresight_drift.
OwnErrors BoresightWarming(const Json& p, const Scenario&) {
  const Vector3d amplitude_rad = kRadPerDeg * Vector3FromJson(p.at("amplitude_deg"));
  const double tau_s = p.at("tau_s"), begin_s = p.at("begin_s"), middle_s = p.at("middle_s");
  OwnErrors own;
  own.boresight_rad = [=](const MapPose& pose) {
    const double now = std::exp(-(pose.t_s - begin_s) / tau_s);
    return Vector3d((now - std::exp(-(middle_s - begin_s) / tau_s)) * amplitude_rad);
  };
  return own;
}

Json DrawBoresightByHeading(const FlightTimes&, Random& random) {
  return {{"amplitude_deg", DrawAxes(3, Sized(0.003, random), random)},
          {"heading_deg", random.Uniform(0.0, 360.0)}};
}

OwnErrors BoresightByHeading(const Json& p, const Scenario&) {
  const Vector3d amplitude_rad = kRadPerDeg * Vector3FromJson(p.at("amplitude_deg"));
  const double heading_rad = kRadPerDeg * p.at("heading_deg").get<double>();
  OwnErrors own;
  own.boresight_rad = [=](const MapPose& pose) {
    const Vector3d forward_m = pose.q_mb * Vector3d::UnitX();
    const double flown_rad = std::atan2(forward_m.x(), forward_m.y());
    return Vector3d(std::cos(flown_rad - heading_rad) * amplitude_rad);
  };
  return own;
}

Json DrawMatcherShift(const FlightTimes&, Random& random) {
  return {{"file_share", random.Uniform()}, {"shift_m", DrawAxes(3, Sized(0.02, random), random)}};
}

OwnErrors MatcherShift(const Json& p, const Scenario&) {
  const double share = p.at("file_share");
  const Vector3d shift_m = Vector3FromJson(p.at("shift_m"));
  OwnErrors own;
  own.pairs = [=](PairData* data) {
    const auto file = static_cast<int>(share * static_cast<double>(data->files.size()));
    for (LidarPair& pair : data->pairs) {
      if (pair.file == file) pair.u_j_s += shift_m;
    }
  };
  return own;
}

constexpr double kWalkStep_s = 1.0;

Json DrawLidarClockWalk(const FlightTimes& times, Random& random) {
  const double begin_s = FirstLidarTag(times) - kWalkStep_s;
  const auto steps = static_cast<int>(std::ceil((LastLidarTag(times) - begin_s) / kWalkStep_s)) + 1;
  const double step_sigma_s = Sized(2e-4, random) / std::sqrt(static_cast<double>(steps));
  return {{"begin_s", begin_s},
          {"step_s", kWalkStep_s},
          {"shifts_s", DrawRandomWalk(steps, step_sigma_s, random)}};
}

OwnErrors LidarClockWalk(const Json& p, const Scenario&) {
  const double begin_s = p.at("begin_s"), step_s = p.at("step_s");
  const auto shifts_s = p.at("shifts_s").get<std::vector<double>>();
  OwnErrors own;
  own.lidar_tag_shift_s = [=](double t_s) {
    return RandomWalkAt(shifts_s, (t_s - begin_s) / step_s);
  };
  return own;
}

struct Physics {
  const char* name;
  Json (*draw)(const FlightTimes& times, Random& random);
  OwnErrors (*make)(const Json& parameters, const Scenario& scenario);
};

constexpr Physics kOutsiders[] = {
    {"scan_torsion", &DrawScanTorsion, &ScanTorsion},
    {"strip_range_jump", &DrawStripRangeJump, &StripRangeJump},
    {"gyro_oscillation", &DrawGyroOscillation, &GyroOscillation},
    {"gnss_waves", &DrawGnssWaves, &GnssWaves},
    {"boresight_warming", &DrawBoresightWarming, &BoresightWarming},
    {"boresight_by_heading", &DrawBoresightByHeading, &BoresightByHeading},
    {"matcher_shift", &DrawMatcherShift, &MatcherShift},
    {"lidar_clock_walk", &DrawLidarClockWalk, &LidarClockWalk},
};

const Physics& Find(const std::string& name) {
  for (const Physics& physics : kOutsiders) {
    if (name == physics.name) return physics;
  }
  throw InvalidInput("unknown effect outside the library '" + name + "'");
}

}  // namespace

std::vector<std::string> UnlistedEffectNames() {
  std::vector<std::string> names;
  for (const Physics& physics : kOutsiders) names.emplace_back(physics.name);
  return names;
}

UnlistedEffect DrawUnlistedEffect(const std::string& name, const FlightTimes& times,
                                  Random& random) {
  return {name, Find(name).draw(times, random)};
}

OwnErrors MakeOwnErrors(const UnlistedEffect& outsider, const Scenario& scenario) {
  if (IsDescribed(outsider.parameters)) return MakeDescribedErrors(outsider.parameters, scenario);
  return Find(outsider.name).make(outsider.parameters, scenario);
}

double LogUniform(double low, double high, Random& random) {
  return low * std::pow(high / low, random.Uniform());
}

std::size_t DrawIndex(std::size_t count, Random& random) {
  return static_cast<std::size_t>(random.Uniform() * static_cast<double>(count));
}

std::vector<double> DrawAxes(std::size_t axes, double size, Random& random) {
  std::vector<double> value(axes, 0.0);
  if (random.Uniform() < 0.5) {
    value[DrawIndex(axes, random)] = EitherSign(size, random);
    return value;
  }
  for (double& axis : value) axis = EitherSign(random.Uniform(0.5, 1.0) * size, random);
  return value;
}

}  // namespace dn
