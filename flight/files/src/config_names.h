#pragma once

#include <dn/files/flight_config.h>

#include <string>
#include <utility>
#include <vector>

namespace dn::files_internal {

/// The words of flight.yaml and their values.
template <class T>
using Words = std::vector<std::pair<std::string, T>>;

const Words<RobustKind>& RobustWords();
const Words<PairSelection::Strategy>& StrategyWords();
const Words<ImuFormat>& ImuFormatWords();
const Words<ImuSampling>& ImuSamplingWords();
/// Units of an IMU file in SI: rates or angles, and forces or velocities.
const Words<double>& RateUnitWords();
const Words<double>& ForceUnitWords();
const Words<GnssFormat>& GnssFormatWords();
const Words<BiasProcess::Type>& ProcessWords();
/// The types of process allowed for GNSS errors.
const Words<BiasProcess::Type>& GnssProcessWords();
const Words<GnssErrorGrowth>& GnssErrorGrowthWords();
const Words<bool>& GhRotationWords();
const Words<TrajectoryColumns::Attitude>& AttitudeWords();
const Words<bool>& NorthWords();
const Words<bool>& BodyWords();
const Words<NetworkConfig::Inertial>& InertialWords();
/// Ends of a pair; true: the second one.
const Words<bool>& EndWords();

/// Returns the word for a value; empty if no word has this value.
template <class T>
std::string FindWord(const T& value, const Words<T>& words) {
  for (const auto& [word, meaning] : words) {
    if (meaning == value) return word;
  }
  return {};
}

}  // namespace dn::files_internal
