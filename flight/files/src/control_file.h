#pragma once

#include <dn/error.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn::files_internal {

/// A row of a control file, in the units and axes of the file.
struct ControlRow {
  std::string name;
  bool geographic = false;
  Eigen::Vector3d coordinates;            ///< east, north, height, or lat, lon [deg], height
  std::optional<Eigen::Vector3d> sigma;   ///< of the coordinates
  std::optional<Eigen::Vector3d> normal;  ///< of a plane: east, north, up
  std::optional<double> normal_sigma;     ///< of a plane
  std::optional<double> extent;           ///< of a plane
  std::optional<double> t_s;              ///< time tag of a return
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();
  std::optional<bool> is_check;  ///< absent: the file has no column `role`
  bool is_corner = false;        ///< see ControlPoint
  FileLocation where;
};

/// Reads the rows of a control file. `geographic`: coordinates without a header are latitude,
/// longitude and height. Throws InvalidInput with file:line, see ReadControl.
std::vector<ControlRow> ReadControlRows(const std::filesystem::path& file, bool geographic);

}  // namespace dn::files_internal
