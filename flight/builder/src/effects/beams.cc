#include "effects.h"
#include "turned_vector.h"

namespace dn::builder_internal {
namespace {

/// Returns the index of the value of the beam of a reading; nullopt if there is none.
std::optional<Eigen::Index> ValueIndex(const LidarReading& reading, int beams) {
  if (reading.beam < 0 || reading.beam >= beams) return std::nullopt;
  return reading.beam;
}

/// The beam leaves the plane across the scan axis by its own value more than the file says. The
/// correction turns the laser vector toward the axis by this angle.
class Angles final : public LidarEffect {
 public:
  Angles(const Eigen::Vector3d& axis_s, int beams) : axis_s_(axis_s), beams_(beams) {}

  int components() const override { return beams_; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    const auto k = ValueIndex(*reading, beams_);
    if (!k) return;
    const TurnedVector turned(axis_s_, value[*k], reading->u_s);
    reading->u_s = turned.u_s;
    reading->J_u = (turned.by_u * reading->J_u).eval();
    reading->J_u.col(column + *k) = turned.by_angle;
  }

 private:
  Eigen::Vector3d axis_s_;
  int beams_;
};

/// measured range = true range + value of the beam.
class Ranges final : public LidarEffect {
 public:
  explicit Ranges(int beams) : beams_(beams) {}

  int components() const override { return beams_; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    const auto k = ValueIndex(*reading, beams_);
    if (!k) return;
    const double range_m = reading->u_s.norm();
    const Eigen::Vector3d e = reading->u_s / range_m;
    reading->u_s -= value[*k] * e;
    reading->J_u -= (value[*k] / range_m) * (reading->J_u - e * (e.transpose() * reading->J_u));
    reading->J_u.col(column + *k) = -e;
  }

 private:
  int beams_;
};

}  // namespace

EffectAction BeamAngles(const LidarConfig& lidar, int beams) {
  return std::make_shared<Angles>(lidar.scan_axis_s.normalized(), beams);
}

EffectAction BeamRanges(int beams) { return std::make_shared<Ranges>(beams); }

}  // namespace dn::builder_internal
