#pragma once

#include <dn/error.h>
#include <dn/geo/local_frame.h>

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace dn {

struct FlightConfig;

/// A laser return on a control point or plane.
struct ControlReturn {
  double t_s = 0.0;                               ///< time tag, offset removed
  Eigen::Vector3d u_s = Eigen::Vector3d::Zero();  ///< laser vector in the sensor frame, m
  /// Unit normal, map axes, of the surface around a return that was found in a cloud. Such a return
  /// observes the distance from that surface only; absent: all three coordinates.
  std::optional<Eigen::Vector3d> normal_m = {};
  /// Noise of each coordinate of the return, or of its distance along the normal, m; absent:
  /// LaserSigma of the flight.
  std::optional<double> sigma_m = {};
  FileLocation where{};
};

/// A surveyed plane: a roof polygon or a patch of ground.
struct ControlPlane {
  Eigen::Vector3d normal_m = Eigen::Vector3d::UnitZ();  ///< unit normal, map axes
  double sigma_m = 0.0;                                 ///< along the normal
  double extent_m = 0.0;                                ///< half width of the plane; 0: not stated
};

/// A surveyed point, or a plane with a point on it.
struct ControlPoint {
  std::string name;
  bool is_check = false;  ///< withheld from the adjustment
  Eigen::Vector3d p_m = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();  ///< of p_m, map axes; of points
  std::optional<ControlPlane> plane;
  /// Whether the point is where planar facets meet, such as the peak of a gable or of a pyramid.
  /// Returns that are found in clouds lie on these facets and together observe all coordinates;
  /// those of any other point lie on the ground around it and observe its height.
  bool is_corner = false;
  std::vector<ControlReturn> returns;
  FileLocation where{};  ///< its first row
};

/// The control of a flight.
struct ControlData {
  std::vector<std::filesystem::path> files;
  std::vector<ControlPoint> points;  ///< in the order of the files; names are unique
};

/// Returns whether the folder of a flight has the files that control.files names.
bool HasControl(const FlightConfig& config);

/// Reads the control files of a flight (docs/reference/control.md). Rows with the same name are
/// further returns of the same point.
///
/// Throws InvalidInput with file:line for
///   - a row with another number of columns, and a value that is not a finite number;
///   - a sigma that is not positive, and a normal or laser vector without length;
///   - an unknown role or shape, and a plane with the shape of a corner;
///   - coordinates outside of the coordinate system, and those that differ from an earlier row of
///     the same name.
/// Also throws for a name of control.checks that no file has. Throws InvalidConfig if the
/// coordinate system is unknown.
ControlData ReadControl(const FlightConfig& config, const LocalFrame& frame);

/// Throws InvalidInput, with file:line and advice, for the first control point that is more than
/// 20 km from all of these positions in map. Such a distance shows another coordinate system, or
/// columns in another order.
void ExpectControlNear(const ControlData& control, const std::vector<Eigen::Vector3d>& flown_m,
                       const LocalFrame& frame, const std::string& crs);

/// Returns the name of the coordinate system of the control files: control.crs, or else strips_crs.
std::string ControlCrs(const FlightConfig& config);

/// Returns the noise of each coordinate of a laser return on a control point, m. It is
/// control.laser_sigma_m, or else that of one end of a pair, sigma_p / sqrt(2).
double LaserSigma(const FlightConfig& config);

}  // namespace dn
