#include <dn/error.h>
#include <dn/rotation.h>

#include <cmath>

#include "effects.h"

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

/// measured scan angle = (1 + value) true scan angle, about the scan axis, from nadir.
class AngleScale final : public LidarEffect {
 public:
  explicit AngleScale(const LidarConfig& lidar) : scan_(lidar) {}

  int components() const override { return 1; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    const double along = scan_.nadir.dot(reading->u_s), across = scan_.side.dot(reading->u_s);
    const double angle = std::atan2(across, along);
    const double turn = -value[0] / (1.0 + value[0]);  // as a fraction of the measured angle
    const Vector3d phi = turn * angle * scan_.axis;
    const RowVector3d d_angle =
        (along * scan_.side - across * scan_.nadir).transpose() / (along * along + across * across);
    const Matrix3d R = Exp(phi).toRotationMatrix();
    reading->u_s = R * reading->u_s;
    const Vector3d by_turn = scan_.axis.cross(reading->u_s);
    reading->J_u = ((R + turn * by_turn * d_angle) * reading->J_u).eval();
    reading->J_u.col(column) = -angle / std::pow(1.0 + value[0], 2) * by_turn;
  }

 private:
  Scan scan_;
};

/// The beam leaves the scan plane by the angle `value` toward the scan axis, but the file has it in
/// the plane. The correction turns the laser vector toward the axis by this angle; `toward_axis` u
/// is the derivative of u with respect to the turn.
class ScanCone final : public LidarEffect {
 public:
  explicit ScanCone(const LidarConfig& lidar) : scan_(lidar) {}

  int components() const override { return 1; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    const Vector3d& axis = scan_.axis;
    const double height = axis.dot(reading->u_s);
    const Vector3d in_plane = reading->u_s - height * axis;
    const double length = in_plane.norm();
    const Vector3d e = in_plane / length;
    const Matrix3d across = Matrix3d::Identity() - axis * axis.transpose() - e * e.transpose();
    const Matrix3d toward_axis =
        axis * e.transpose() - e * axis.transpose() - height / length * across;
    const double c = std::cos(value[0]), s = std::sin(value[0]);
    const Matrix3d M = c * Matrix3d::Identity() + s * toward_axis;
    const Vector3d by_value = (c * toward_axis - s * Matrix3d::Identity()) * reading->u_s;
    reading->u_s = M * reading->u_s;
    reading->J_u = (M * reading->J_u).eval();
    reading->J_u.col(column) = by_value;
  }

 private:
  Scan scan_;
};

const LidarConfig& RequireLidar(const Flight& flight) {
  if (flight.config.lidar) return *flight.config.lidar;
  throw InvalidConfig("estimate: an effect on the lidar needs the section lidar in flight.yaml");
}

}  // namespace

EffectAction LidarAngleScale(const EffectSite& site) {
  return std::make_shared<AngleScale>(RequireLidar(site.flight));
}

EffectAction LidarScanCone(const EffectSite& site) {
  return std::make_shared<ScanCone>(RequireLidar(site.flight));
}

}  // namespace dn::builder_internal
