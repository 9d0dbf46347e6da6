#pragma once

#include <dn/imu/imu_data.h>

#include <Eigen/Core>
#include <filesystem>
#include <vector>

namespace dn {

/// One row of inertial data in body axes. It is a mean over the interval that ends at its time, or
/// a point sample (ImuSampling).
struct ImuRow {
  double t_s = 0.0;
  Eigen::Vector3d w_ib_b_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d f_b_mps2 = Eigen::Vector3d::Zero();
};

/// Returns the inertial data that two or more rows in the order of time contain. Of the options,
/// only format, sampling, time span and max_gap_s apply. `file` is named in messages. Throws as
/// ReadImu does for values in wrong units.
ImuData MakeImuData(const std::vector<ImuRow>& rows, const ImuReadOptions& options,
                    const std::filesystem::path& file);

}  // namespace dn
