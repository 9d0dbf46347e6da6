#include <dn/calibration/laser_departures.h>
#include <dn/factors/lidar_effect.h>
#include <dn/flight/scan_angle.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

namespace dn {
namespace {

// Usual size of what has no name.
constexpr double kLaserM = 0.02;
constexpr int kScanAngleBumps = 7;
constexpr double kNarrowestRad = 1e-3;

/// measured = true + sum of weighted three-vectors in the sensor frame.
class LaserOffset final : public LidarEffect {
 public:
  using WeightsOf = std::function<void(const LidarReading&, Eigen::VectorXd*)>;
  LaserOffset(int count, WeightsOf weights) : count_(count), weights_(std::move(weights)) {}
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
  WeightsOf weights_;
};

}  // namespace

OwnEffect LaserByScanAngle(const LidarConfig& lidar, double first_rad, double last_rad) {
  const double step = (last_rad - first_rad) / (kScanAngleBumps - 1);
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

OwnEffect LaserByScanAngle(const FlightNetwork& network) {
  const LidarConfig& lidar = *network.flight().config.lidar;
  double low_rad = 0.0, high_rad = 0.0;
  for (const FlightNetwork::PairEdge& edge : network.pair_edges) {
    for (const Eigen::Vector3d& u_s : {edge.pair.u_i_s, edge.pair.u_j_s}) {
      low_rad = std::min(low_rad, ScanAngle(lidar, u_s));
      high_rad = std::max(high_rad, ScanAngle(lidar, u_s));
    }
  }
  return LaserByScanAngle(lidar, low_rad, std::max(high_rad, low_rad + kNarrowestRad));
}

OwnEffect LaserByStrip(const std::vector<StripInterval>& strips) {
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
