#pragma once

#include <dn/imu/imu_data.h>
#include <dn/imu/imu_model.h>

#include <cmath>
#include <cstdint>
#include <random>

namespace dn::testing {

constexpr double kWhiteRateHz = 100.0;

/// Returns a model with white noise of 1e-4 rad/sqrt(s) and 1e-3 m/s/sqrt(s); a sample has 1e-3
/// rad/s and 1e-2 m/s^2.
inline ImuModel WhiteModel() {
  ImuModel model;
  model.gyro.white = 1e-4;
  model.accel.white = 1e-3;
  return model;
}

/// Returns samples of a sensor with this noise at a constant rate and specific force.
inline ImuData WhiteImu(std::uint64_t seed, double span_s, double gyro_ratio = 1.0,
                        double accel_ratio = 1.0) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const auto noise = [&](double white) {
    const double x = normal(random), y = normal(random), z = normal(random);
    return Eigen::Vector3d(white * std::sqrt(kWhiteRateHz) * Eigen::Vector3d(x, y, z));
  };
  ImuData imu;
  imu.nominal_dt_s = 1.0 / kWhiteRateHz;
  for (long k = 1; k <= std::lround(span_s * kWhiteRateHz); ++k) {
    ImuSample sample;
    sample.t_s = 1000.0 + static_cast<double>(k) / kWhiteRateHz;
    sample.dt_s = imu.nominal_dt_s;
    sample.w_ib_b_radps = Eigen::Vector3d(0.01, -0.02, 0.3) + noise(gyro_ratio * 1e-4);
    sample.f_b_mps2 = Eigen::Vector3d(0.1, 0.2, -9.8) + noise(accel_ratio * 1e-3);
    imu.samples.push_back(sample);
  }
  return imu;
}

}  // namespace dn::testing
