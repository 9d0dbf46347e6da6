#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/rotation.h>

#include <cmath>

#include "effects.h"
#include "turned_vector.h"

namespace dn::builder_internal {
namespace {

using Eigen::Matrix3d;
using Eigen::RowVector3d;
using Eigen::Vector3d;

/// Scan axis and directions of the scan plane in the scanner frame: nadir has scan angle 0, side 90
/// deg.
struct Scan {
  Vector3d axis, nadir, side;

  explicit Scan(const LidarConfig& lidar)
      : axis(lidar.scan_axis_s.normalized()),
        nadir((lidar.nadir_axis_s - axis * axis.dot(lidar.nadir_axis_s)).normalized()),
        side(axis.cross(nadir)) {}
};

/// The scan angle of a laser vector and its derivative with respect to the vector.
struct ScanAngle {
  double angle_rad;
  RowVector3d by_u;

  ScanAngle(const Scan& scan, const Vector3d& u_s) {
    const double along = scan.nadir.dot(u_s), across = scan.side.dot(u_s);
    angle_rad = std::atan2(across, along);
    by_u =
        (along * scan.side - across * scan.nadir).transpose() / (along * along + across * across);
  }
};

/// measured scan angle = (1 + value) true scan angle, about the scan axis, from nadir.
class AngleScale final : public LidarEffect {
 public:
  explicit AngleScale(const LidarConfig& lidar) : scan_(lidar) {}

  int components() const override { return 1; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    const ScanAngle at(scan_, reading->u_s);
    const double turn = -value[0] / (1.0 + value[0]);  // as a fraction of the measured angle
    const Vector3d phi = turn * at.angle_rad * scan_.axis;
    const Matrix3d R = Exp(phi).toRotationMatrix();
    reading->u_s = R * reading->u_s;
    const Vector3d by_turn = scan_.axis.cross(reading->u_s);
    reading->J_u = ((R + turn * by_turn * at.by_u) * reading->J_u).eval();
    reading->J_u.col(column) = -at.angle_rad / std::pow(1.0 + value[0], 2) * by_turn;
  }

 private:
  Scan scan_;
};

/// The beam leaves the scan plane by the angle `value` toward the scan axis, but the file has it in
/// the plane. The correction turns the laser vector toward the axis by this angle.
class ScanCone final : public LidarEffect {
 public:
  explicit ScanCone(const LidarConfig& lidar) : axis_(Scan(lidar).axis) {}

  int components() const override { return 1; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    const TurnedVector turned(axis_, value[0], reading->u_s);
    reading->u_s = turned.u_s;
    reading->J_u = (turned.by_u * reading->J_u).eval();
    reading->J_u.col(column) = turned.by_angle;
  }

 private:
  Vector3d axis_;
};

/// The beam leaves the scan plane toward the scan axis by value sin(4 a) at the scan angle a. The
/// file has the beam in the plane. A sine of the angle a itself is a boresight yaw. Sines of 2 a
/// and 3 a resemble it over the field of view of a scanner.
class ScanTorsion final : public LidarEffect {
 public:
  explicit ScanTorsion(const LidarConfig& lidar) : scan_(lidar) {}

  int components() const override { return 1; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    constexpr double kMultiple = 4.0;
    const ScanAngle at(scan_, reading->u_s);
    const double sine = std::sin(kMultiple * at.angle_rad);
    const double slope = kMultiple * std::cos(kMultiple * at.angle_rad);
    const TurnedVector turned(scan_.axis, value[0] * sine, reading->u_s);
    const Matrix3d by_u = turned.by_u + turned.by_angle * value[0] * slope * at.by_u;
    reading->u_s = turned.u_s;
    reading->J_u = (by_u * reading->J_u).eval();
    reading->J_u.col(column) = sine * turned.by_angle;
  }

 private:
  Scan scan_;
};

const LidarConfig& RequireLidar(const EffectSite& site) {
  if (site.flight.config.lidar) return ScannerAt(site.flight.config, site.scanner);
  throw InvalidConfig("estimate: an effect on the lidar needs the section lidar in flight.yaml");
}

}  // namespace

EffectAction LidarAngleScale(const EffectSite& site) {
  return std::make_shared<AngleScale>(RequireLidar(site));
}

EffectAction LidarScanCone(const EffectSite& site) {
  return std::make_shared<ScanCone>(RequireLidar(site));
}

EffectAction LidarScanTorsion(const EffectSite& site) {
  return std::make_shared<ScanTorsion>(RequireLidar(site));
}

}  // namespace dn::builder_internal
