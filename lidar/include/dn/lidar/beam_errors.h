#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <vector>

namespace dn {

/// Errors of the beams of a rotating scanner; each list has one element per beam, or is empty.
struct BeamErrors {
  Eigen::Vector3d scan_axis_s = Eigen::Vector3d::UnitX();
  std::vector<double> angle_rad;  ///< true angle toward +scan_axis minus that of the laser vector
  std::vector<double> range_m;    ///< measured range minus true range

  /// Returns the laser vector without the errors of its beam. Throws InvalidInput if there is no
  /// such beam.
  Eigen::Vector3d Remove(const Eigen::Vector3d& u_s, int beam) const;
};

}  // namespace dn
