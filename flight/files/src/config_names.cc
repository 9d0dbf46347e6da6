#include "config_names.h"

#include <dn/geo/local_frame.h>

namespace dn::files_internal {

const Words<RobustKind>& RobustWords() {
  static const Words<RobustKind> words{
      {"none", RobustKind::kNone}, {"huber", RobustKind::kHuber}, {"cauchy", RobustKind::kCauchy}};
  return words;
}

const Words<PairSelection::Strategy>& StrategyWords() {
  using Strategy = PairSelection::Strategy;
  static const Words<Strategy> words{{"all", Strategy::kAll},
                                     {"max", Strategy::kMax},
                                     {"freq", Strategy::kFreq},
                                     {"time_window", Strategy::kTimeWindow}};
  return words;
}

const Words<ImuFormat>& ImuFormatWords() {
  static const Words<ImuFormat> words{{"odyn", ImuFormat::kOdyn},
                                      {"increments", ImuFormat::kIncrements}};
  return words;
}

const Words<ImuSampling>& ImuSamplingWords() {
  static const Words<ImuSampling> words{{"mean", ImuSampling::kMean},
                                        {"instantaneous", ImuSampling::kInstantaneous}};
  return words;
}

const Words<double>& RateUnitWords() {
  static const Words<double> words{{"rad/s", 1.0}, {"deg/s", kRadPerDeg}};
  return words;
}

const Words<double>& ForceUnitWords() {
  static const Words<double> words{{"m/s^2", 1.0}, {"g", kStandardGravityMps2}};
  return words;
}

const Words<GnssFormat>& GnssFormatWords() {
  static const Words<GnssFormat> words{{"odyn", GnssFormat::kOdyn},
                                       {"rtklib", GnssFormat::kRtklib},
                                       {"ob_gins", GnssFormat::kObGins},
                                       {"nmea", GnssFormat::kNmea}};
  return words;
}

const Words<BiasProcess::Type>& ProcessWords() {
  using Type = BiasProcess::Type;
  static const Words<Type> words{{"random_constant", Type::kRandomConstant},
                                 {"gauss_markov", Type::kGaussMarkov},
                                 {"random_walk", Type::kRandomWalk}};
  return words;
}

const Words<BiasProcess::Type>& GnssProcessWords() {
  static const Words<BiasProcess::Type> words{{"gauss_markov", BiasProcess::Type::kGaussMarkov}};
  return words;
}

const Words<GnssErrorGrowth>& GnssErrorGrowthWords() {
  static const Words<GnssErrorGrowth> words{{"none", GnssErrorGrowth::kNone},
                                            {"bank", GnssErrorGrowth::kBank}};
  return words;
}

const Words<bool>& GhRotationWords() {
  static const Words<bool> words{{"exp", true}, {"small_angle", false}};
  return words;
}

const Words<TrajectoryColumns::Attitude>& AttitudeWords() {
  using Attitude = TrajectoryColumns::Attitude;
  static const Words<Attitude> words{{"quaternion_ned", Attitude::kQuaternionNed},
                                     {"quaternion_enu", Attitude::kQuaternionEnu},
                                     {"roll_pitch_heading_deg", Attitude::kRollPitchHeading},
                                     {"roll_pitch_yaw_enu_deg", Attitude::kRollPitchYawEnu}};
  return words;
}

const Words<bool>& NorthWords() {
  static const Words<bool> words{{"geodetic", false}, {"grid", true}};
  return words;
}

const Words<bool>& BodyWords() {
  static const Words<bool> words{{"FRD", false}, {"FLU", true}};
  return words;
}

const Words<NetworkConfig::Inertial>& InertialWords() {
  using Inertial = NetworkConfig::Inertial;
  static const Words<Inertial> words{{"preintegrated", Inertial::kPreintegrated},
                                     {"raw", Inertial::kRaw}};
  return words;
}

const Words<bool>& EndWords() {
  static const Words<bool> words{{"i", false}, {"j", true}};
  return words;
}

}  // namespace dn::files_internal
