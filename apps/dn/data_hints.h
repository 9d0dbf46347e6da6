#pragma once

#include <dn/files/flight.h>
#include <dn/navigation/gnss_lag.h>
#include <dn/navigation/sensor_agreement.h>

#include <optional>
#include <string>
#include <vector>

namespace dn::apps {

/// Agreement of inertial and GNSS data in axes and clocks, computed before any adjustment.
struct DataAgreement {
  std::optional<BodyDirections> directions;
  std::optional<TurnComparison> turns;
  std::optional<GnssLag> lag;
};

DataAgreement FindDataAgreement(const Flight& flight, int threads = 1);

/// A likely mistake in the data or in flight.yaml, with its correction.
struct DataHint {
  std::string text;
  std::string key;    ///< key of flight.yaml that corrects it; empty if there is none
  std::string value;  ///< corrected value of the key, in YAML
  /// True if the poses of the flight are wrong or doubtful, so that they say nothing of others.
  bool doubts_poses = false;
};

/// Returns a hint for each axis, clock or coordinate convention that contradicts flight.yaml.
/// Consistent data give an empty list.
std::vector<DataHint> DataHints(const Flight& flight, const DataAgreement& agreement);

bool DoubtsPoses(const DataHint& hint);

/// Returns whether a hint corrects the clock of the GNSS or inertial data.
bool IsClockHint(const DataHint& hint);

/// Formats the hint on one line, with the key that corrects it.
std::string HintText(const DataHint& hint);

/// Describes a mistake in the axes of imu.file and its remedy.
std::string HintText(const AxesMistake& mistake);

/// Returns the word of flight.yaml for an attitude convention.
const char* AttitudeWord(TrajectoryColumns::Attitude attitude);

/// Returns the axes of the data as three letters, e.g. RFU: x right, y forward, z up.
/// R_imu_to_body: signed permutation from the data's axes to forward-right-down.
std::string AxesName(const Eigen::Matrix3d& R_imu_to_body);

/// Formats a matrix for YAML, e.g. "[[0, 1, 0], [1, 0, 0], [0, 0, -1]]".
std::string MatrixText(const Eigen::Matrix3d& matrix);

}  // namespace dn::apps
