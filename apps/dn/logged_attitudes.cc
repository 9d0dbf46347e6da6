#include "logged_attitudes.h"

#include <dn/error.h>
#include <dn/files/flight.h>
#include <dn/files/yaml_sections.h>
#include <dn/navigation/attitude_agreement.h>
#include <dn/report/value_words.h>
#include <dn/rotation.h>
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "data_hints.h"

namespace dn::apps {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// Sensors are mounted along the axes of the body, or at least nearly so.
constexpr double kParallelRad = 20.0 / 180.0 * std::numbers::pi;

/// Returns the rotation between parallel axes that is nearest to a rotation.
Matrix3d NearestAxes(const Matrix3d& R) {
  Matrix3d axes = Matrix3d::Zero();
  Eigen::Index row = 0, col = 0;
  R.cwiseAbs().maxCoeff(&row, &col);
  axes(row, col) = std::copysign(1.0, R(row, col));
  const Eigen::Index next = (col + 1) % 3;
  Vector3d rest = R.col(next);
  rest[row] = 0.0;
  Eigen::Index other = 0;
  rest.cwiseAbs().maxCoeff(&other);
  axes(other, next) = std::copysign(1.0, rest[other]);
  const Eigen::Index last = (col + 2) % 3;
  axes.col(last) = axes.col(col).cross(axes.col(next));
  return axes;
}

std::string TrajectorySection(const FileContent& gnss, const std::filesystem::path& folder) {
  return fmt::format(
      "\ntrajectory:\n  file: {}\n  columns: {}\n  attitude: {}\n"
      "  sigma_xy_m: 1\n  sigma_z_m: 1\n  sigma_rp_deg: 1\n  sigma_y_deg: 1\n",
      QuoteYaml(gnss.file.lexically_relative(folder).generic_string()),
      FormatColumnNames(gnss.attitude),
      AttitudeWord(TrajectoryColumns::Attitude::kRollPitchHeading));
}

}  // namespace

bool LoggedAttitudes::HasParallelAxes() const { return axes_rest_rad < kParallelRad; }

std::string LoggedAttitudes::Text(const std::string& gnss_name, const std::string& imu_name) const {
  std::string text = fmt::format(
      "the attitudes in {} show the rotations of {}: its tags are {} s {}", gnss_name, imu_name,
      FormatWithSigma(std::abs(offset_s), found.sigma_offset_s), offset_s < 0.0 ? "early" : "late");
  if (!HasParallelAxes()) return text + ", and its axes are not parallel to those of the sensor";
  return text + fmt::format(", and its axes are parallel to those of the sensor within {:.1f} deg",
                            axes_rest_rad * 180.0 / std::numbers::pi);
}

std::optional<LoggedAttitudes> CompareLoggedAttitudes(const FileContent& gnss,
                                                      const std::string& imu_text,
                                                      const std::filesystem::path& folder) {
  if (gnss.attitude.empty() || imu_text.empty()) return std::nullopt;
  try {
    const Flight flight =
        ReadFlight(ParseFlightConfig(imu_text + TrajectorySection(gnss, folder), folder),
                   {.imu = true, .gnss = false, .trajectory = true});
    const std::optional<UnitAgreement> found = CompareAttitudes(flight);
    if (!found) return std::nullopt;
    LoggedAttitudes log{*found};
    log.offset_s = found->offset_s + 0.5 * found->drift * (found->last_s - found->first_s);
    log.R_axes = NearestAxes(found->q_ba.toRotationMatrix());
    log.axes_rest_rad = Log(found->q_ba * Eigen::Quaterniond(log.R_axes).conjugate()).norm();
    return log;
  } catch (const InvalidInput&) {  // rows without an attitude, for example
    return std::nullopt;
  }
}

}  // namespace dn::apps
