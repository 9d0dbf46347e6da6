#pragma once

#include <dn/imu/imu_effect.h>

#include <Eigen/Core>

namespace dn::testing {

class GyroScale final : public ImuEffect {
 public:
  int components() const override { return 3; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               ImuReading* reading) const override {
    const Eigen::Vector3d inverse = (1.0 + value.array()).inverse();
    reading->w_b = inverse.cwiseProduct(reading->w_b);
    reading->J_w = inverse.asDiagonal() * reading->J_w;
    reading->J_w.middleCols<3>(column).diagonal() = -inverse.cwiseProduct(reading->w_b);
  }
};

}  // namespace dn::testing
