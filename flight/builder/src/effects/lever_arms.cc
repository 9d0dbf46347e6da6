#include <dn/files/scanners.h>

#include "effects.h"

namespace dn::builder_internal {
namespace {

/// true lever arm = assumed + value, body axes.
class AntennaArm final : public GnssEffect {
 public:
  int components() const override { return 3; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               GnssReading* reading) const override {
    reading->arm_b_m += value;
    reading->J_arm.middleCols<3>(column).setIdentity();
  }
};

/// true lever arm = assumed + value, body axes.
class ScannerArm final : public LidarEffect {
 public:
  int components() const override { return 3; }

  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    reading->arm_b_m += value;
    reading->J_arm.middleCols<3>(column).setIdentity();
  }
};

}  // namespace

EffectAction GnssLeverArm(const EffectSite&) { return std::make_shared<AntennaArm>(); }

EffectAction LidarLeverArm(const EffectSite&) { return std::make_shared<ScannerArm>(); }

Eigen::VectorXd ConfiguredGnssLeverArm(const FlightConfig& config, std::size_t) {
  return config.gnss ? config.gnss->lever_arm_b_m : Eigen::Vector3d::Zero().eval();
}

Eigen::VectorXd ConfiguredLidarLeverArm(const FlightConfig& config, std::size_t scanner) {
  if (!config.lidar) return Eigen::Vector3d::Zero();
  return ScannerAt(config, scanner).mounting.lever_arm_b_m;
}

}  // namespace dn::builder_internal
