#include "error_quantity.h"

#include <dn/error.h>
#include <dn/geo/local_frame.h>

#include <cmath>

#include "scan_angle.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kMetersPerSecond2PerMilligal = 1e-5;

/// Returns the error as a vector function of the time, in `unit` of the quantity.
std::function<Vector3d(double t_s)> TimeFunction(const DrawnError& error, double unit) {
  return [=](double t_s) {
    return Vector3d(unit * error.shape(t_s - error.begin_s) * error.amplitude);
  };
}

OwnErrors GyroErrors(const DrawnError& error, const Scenario&) {
  OwnErrors own;
  own.gyro_radps = TimeFunction(error, kRadPerDeg / 3600.0);
  return own;
}

OwnErrors AccelerometerErrors(const DrawnError& error, const Scenario&) {
  OwnErrors own;
  own.specific_force_mps2 = TimeFunction(error, kMetersPerSecond2PerMilligal);
  return own;
}

OwnErrors GnssErrors(const DrawnError& error, const Scenario&) {
  OwnErrors own;
  own.antenna_enu_m = TimeFunction(error, 1.0);
  return own;
}

OwnErrors ClockErrors(const DrawnError& error, const Scenario&) {
  OwnErrors own;
  own.lidar_tag_shift_s = [=](double t_s) {
    return error.shape(t_s - error.begin_s) * error.amplitude.x();
  };
  return own;
}

double HeadingDeg(const MapPose& pose) {
  const Vector3d forward = pose.q_mb * Vector3d::UnitX();
  const double heading_deg = std::atan2(forward.x(), forward.y()) / kRadPerDeg;
  return heading_deg < 0.0 ? heading_deg + 360.0 : heading_deg;
}

OwnErrors BoresightErrors(const DrawnError& error, const Scenario&) {
  OwnErrors own;
  own.boresight_rad = [=, by_heading = error.of == "heading_deg"](const MapPose& pose) {
    const double x = by_heading ? HeadingDeg(pose) : pose.t_s - error.begin_s;
    return Vector3d(kRadPerDeg * error.shape(x) * error.amplitude);
  };
  return own;
}

/// Returns the argument of the shape for a laser vector.
std::function<double(const Vector3d& u_s, double t_s)> LaserArgument(const DrawnError& error,
                                                                     const ScanAxes& axes) {
  if (error.of == "scan_angle_deg") {
    return [=](const Vector3d& u_s, double) { return axes.Angle(u_s) / kRadPerDeg; };
  }
  if (error.of == "range_m") return [](const Vector3d& u_s, double) { return u_s.norm(); };
  return [begin_s = error.begin_s](const Vector3d&, double t_s) { return t_s - begin_s; };
}

/// Returns the errors of the scanner. `change` is the change of a laser vector per unit.
template <class Change>
OwnErrors LaserErrors(const DrawnError& error, const ScanAxes& axes, Change change) {
  OwnErrors own;
  own.laser_vector = [=, argument = LaserArgument(error, axes)](const Vector3d& u_s, double t_s) {
    return Vector3d(u_s + error.shape(argument(u_s, t_s)) * error.amplitude.x() * change(u_s));
  };
  return own;
}

OwnErrors RangeErrors(const DrawnError& error, const Scenario& scenario) {
  return LaserErrors(error, ScanAxes(scenario),
                     [](const Vector3d& u_s) { return u_s.normalized(); });
}

OwnErrors RangeScaleErrors(const DrawnError& error, const Scenario& scenario) {
  return LaserErrors(error, ScanAxes(scenario),
                     [](const Vector3d& u_s) { return Vector3d(1e-6 * u_s); });
}

OwnErrors ForwardAngleErrors(const DrawnError& error, const Scenario& scenario) {
  const ScanAxes axes(scenario);
  return LaserErrors(error, axes, [axis_s = axes.axis_s](const Vector3d& u_s) {
    return Vector3d(kRadPerDeg * u_s.norm() * axis_s);
  });
}

OwnErrors ScanAngleErrors(const DrawnError& error, const Scenario& scenario) {
  const ScanAxes axes(scenario);
  return LaserErrors(error, axes, [axis_s = axes.axis_s](const Vector3d& u_s) {
    return Vector3d(kRadPerDeg * axis_s.cross(u_s));
  });
}

}  // namespace

const std::vector<ErrorQuantity>& ErrorQuantities() {
  const std::vector<std::string> time = {"time_s"};
  const std::vector<std::string> laser = {"time_s", "scan_angle_deg", "range_m"};
  static const std::vector<ErrorQuantity> quantities = {
      {"gyro_deg_h", 3, time, true, &GyroErrors},
      {"accelerometer_mgal", 3, time, true, &AccelerometerErrors},
      {"gnss_m", 3, time, true, &GnssErrors},
      {"boresight_deg", 3, {"time_s", "heading_deg"}, true, &BoresightErrors},
      {"lidar_range_m", 1, laser, true, &RangeErrors},
      {"lidar_range_ppm", 1, laser, true, &RangeScaleErrors},
      {"lidar_forward_deg", 1, laser, true, &ForwardAngleErrors},
      {"lidar_scan_angle_deg", 1, laser, true, &ScanAngleErrors},
      {"lidar_clock_s", 1, time, false, &ClockErrors},
  };
  return quantities;
}

const ErrorQuantity& FindErrorQuantity(const std::string& name) {
  for (const ErrorQuantity& quantity : ErrorQuantities()) {
    if (name == quantity.name) return quantity;
  }
  throw InvalidInput("unknown quantity with an error '" + name + "'");
}

}  // namespace dn
