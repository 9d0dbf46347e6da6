#pragma once

#include <dn/flight/flight.h>
#include <dn/navigation/sensor_agreement.h>

#include <optional>
#include <string>
#include <vector>

namespace dn::apps {

/// What inertial and GNSS data show of axes, clocks and coordinates before any adjustment.
struct DataAgreement {
  std::optional<BodyDirections> directions;
  std::optional<TurnComparison> turns;
};

DataAgreement FindDataAgreement(const Flight& flight, int threads = 1);

/// A likely mistake in the data or in flight.yaml, with what mends it.
struct DataHint {
  std::string text;
  std::string key;    ///< of flight.yaml that mends it; empty where none does
  std::string value;  ///< that it takes, YAML
};

/// Axes, clocks, coordinates that do not look as declared; none of well-formed data.
std::vector<DataHint> DataHints(const Flight& flight, const DataAgreement& agreement);

/// The hint on one line, with the key that mends it.
std::string TextOf(const DataHint& hint);

/// Axes of data by three letters, say RFU: x right, y forward, z up. R_imu_to_body: to
/// forward-right-down, a permutation.
std::string AxesName(const Eigen::Matrix3d& R_imu_to_body);

/// "[[0, 1, 0], [1, 0, 0], [0, 0, -1]]".
std::string MatrixText(const Eigen::Matrix3d& matrix);

}  // namespace dn::apps
