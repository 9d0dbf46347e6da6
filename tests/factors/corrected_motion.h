#pragma once

#include <dn/imu/preintegration.h>
#include <gtest/gtest.h>

#include <memory>

#include "factors/gyro_scale.h"
#include "testing/earth_motion.h"

namespace dn::testing {

/// Inertial data of a motion, with biases, and with an inertial effect in addition.
class CorrectedMotion : public ::testing::Test {
 protected:
  const EarthMotion motion_ = PlaneMotion();
  const ImuData imu_ = motion_.Measure(0.0, 6.0, 200.0);
  const ImuCorrection plain_{
      Eigen::Vector3d(1e-4, -2e-4, 3e-4), Eigen::Vector3d(0.01, 0.02, -0.01), {}};
  const ImuCorrection scaled_{Eigen::Vector3d(1e-4, -2e-4, 3e-4),
                              Eigen::Vector3d(0.01, 0.02, -0.01),
                              {{std::make_shared<GyroScale>(), Eigen::Vector3d(1e-3, 0.0, -2e-3)}}};
};

}  // namespace dn::testing
