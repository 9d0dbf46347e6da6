#pragma once

#include <dn/files/file_content.h>
#include <dn/imu/unit_agreement.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>

namespace dn::apps {

/// Clock of a GNSS log and axes of the inertial data, from the attitudes in the log.
struct LoggedAttitudes {
  UnitAgreement found;    ///< a: inertial data, b: log
  double offset_s = 0.0;  ///< tags of the log minus those of the inertial data, in the middle
  /// The rotation between parallel axes that is nearest to found.q_ba.
  Eigen::Matrix3d R_axes = Eigen::Matrix3d::Identity();
  double axes_rest_rad = 0.0;

  /// Returns whether the axes of the inertial data are parallel to those of the log.
  bool HasParallelAxes() const;
  /// Describes the offset and the rest of the rotation.
  std::string Text(const std::string& gnss_name, const std::string& imu_name) const;
};

/// Compares the attitudes in a GNSS log, which flight controllers write, with the gyros. imu_text
/// is the section `imu` of flight.yaml. Returns nullopt without attitudes, without inertial data,
/// if one of the two cannot be read, and if the two do not show the same turns at one offset.
std::optional<LoggedAttitudes> CompareLoggedAttitudes(const FileContent& gnss,
                                                      const std::string& imu_text,
                                                      const std::filesystem::path& folder);

}  // namespace dn::apps
