#include <dn/adjustment/laser_departures.h>
#include <dn/factors/lidar_effect.h>
#include <dn/files/scan_angle.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

namespace dn {
namespace {

// Typical size of an unmodelled discrepancy, m.
constexpr double kLaserM = 0.02;
constexpr int kScanAngleBumps = 7;
constexpr double kNarrowestRad = 1e-3;

/// Laser offset: measured = true + weighted sum of three-vectors in the sensor frame.
class LaserOffset final : public LidarEffect {
 public:
  using WeightFunction = std::function<void(const LidarReading&, Eigen::VectorXd*)>;
  LaserOffset(int count, WeightFunction weights) : count_(count), weights_(std::move(weights)) {}
  int components() const override { return 3 * count_; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(count_);
    weights_(*reading, &w);
    for (int k = 0; k < count_; ++k) {
      if (w[k] == 0.0) continue;
      reading->u_s -= w[k] * value.segment<3>(3 * k);
      reading->J_u.middleCols<3>(column + 3 * k) = -w[k] * Eigen::Matrix3d::Identity();
    }
  }

 private:
  int count_;
  WeightFunction weights_;
};

/// Collects the range of the scan angles.
class ScanAngles {
 public:
  explicit ScanAngles(const LidarConfig& lidar) : lidar_(lidar) {}

  void Add(const Eigen::Vector3d& u_s) {
    const double angle_rad = ScanAngle(lidar_, u_s);
    low_rad_ = std::min(low_rad_, angle_rad);
    high_rad_ = std::max(high_rad_, angle_rad);
  }

  ScanAngleRange Range() const { return {low_rad_, std::max(high_rad_, low_rad_ + kNarrowestRad)}; }

 private:
  const LidarConfig& lidar_;
  double low_rad_ = 0.0, high_rad_ = 0.0;
};

}  // namespace

UserEffect LaserByScanAngle(const LidarConfig& lidar, const ScanAngleRange& range) {
  const double first_rad = range.low_rad;
  const double step = (range.high_rad - first_rad) / (kScanAngleBumps - 1);
  auto weights = [=](const LidarReading& reading, Eigen::VectorXd* w) {
    const double angle = ScanAngle(lidar, reading.u_s);
    for (int k = 0; k < kScanAngleBumps; ++k) {
      const double off = (angle - first_rad - step * k) / step;
      (*w)[k] = std::exp(-0.5 * off * off);
    }
  };
  return {"laser vectors by scan angle",
          std::make_shared<LaserOffset>(kScanAngleBumps, std::move(weights)),
          Eigen::VectorXd::Constant(3 * kScanAngleBumps, kLaserM)};
}

UserEffect LaserByScanAngle(const FlightNetwork& network) {
  ScanAngles angles(*network.flight().config.lidar);
  for (const PairEdge& edge : network.pairs().edges()) {
    angles.Add(edge.pair.u_i_s);
    angles.Add(edge.pair.u_j_s);
  }
  return LaserByScanAngle(*network.flight().config.lidar, angles.Range());
}

ScanAngleRange FindScanAngleRange(const LidarConfig& lidar, const std::vector<PairEnds>& pairs) {
  ScanAngles angles(lidar);
  for (const PairEnds& pair : pairs) {
    angles.Add(pair.i.u_s);
    angles.Add(pair.j.u_s);
  }
  return angles.Range();
}

UserEffect LaserByScanAngle(const LidarConfig& lidar, const std::vector<PairEnds>& pairs) {
  return LaserByScanAngle(lidar, FindScanAngleRange(lidar, pairs));
}

UserEffect LaserByStrip(const std::vector<StripInterval>& strips) {
  auto weights = [strips](const LidarReading& reading, Eigen::VectorXd* w) {
    const double t_s = reading.tag_s - reading.delay_s;
    for (std::size_t k = 0; k < strips.size(); ++k) {
      if (t_s >= strips[k].t0_s && t_s <= strips[k].t1_s) (*w)[static_cast<Eigen::Index>(k)] = 1.0;
    }
  };
  const auto count = static_cast<int>(strips.size());
  return {"laser vectors by strip", std::make_shared<LaserOffset>(count, std::move(weights)),
          Eigen::VectorXd::Constant(3 * count, kLaserM)};
}

}  // namespace dn
