#pragma once

#include <dn/eigen_alignment.h>
#include <dn/files/control.h>

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace dn {

/// Tie points: ground points that this flight and another one measured.
struct TieData {
  /// One point per pair, withheld, with one return. Its position is not known, and p_m is 0. Its
  /// name is FOLDER/FILE:LINE of the pair, the same in both flights.
  ControlData points;
  /// Covariance of the difference of the two ends, axes of this flight's map frame, m^2; nullopt
  /// if this flight measured the second end.
  std::vector<std::optional<Eigen::Matrix3d>> covariance_m2;
};

/// Reads the pairs that the section `ties` names, and keeps `count` of each entry, spread over time
/// and files. The choice depends only on the files, so that both flights make the same one.
///
/// Throws InvalidInput as ReadPairs does, and for laser vectors that were computed with an assumed
/// boresight. Throws InvalidConfig for several scanners, or for one with several beams.
TieData ReadTies(const FlightConfig& config);

}  // namespace dn
