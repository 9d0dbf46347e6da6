#include <dn/imu/white_rows.h>
#include <dn/median.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kWindowS = 1.0;
constexpr std::size_t kLeastRows = 5;

/// Returns the rows that differ from the row before.
std::vector<ImuSample> OwnRows(const std::vector<ImuSample>& samples) {
  std::vector<ImuSample> rows;
  for (const ImuSample& sample : samples) {
    const bool same = !rows.empty() && rows.back().w_ib_b_radps == sample.w_ib_b_radps &&
                      rows.back().f_b_mps2 == sample.f_b_mps2;
    if (!same) rows.push_back(sample);
  }
  return rows;
}

/// Returns the largest density of the three axes over the rows [first, last).
double Density(const std::vector<ImuSample>& rows, std::size_t first, std::size_t last,
               Vector3d ImuSample::*value) {
  constexpr double kWhiteNoiseFactor = 6.0;
  Vector3d sum = Vector3d::Zero();
  for (std::size_t k = first + 2; k < last; ++k) {
    sum += (rows[k].*value - 2.0 * (rows[k - 1].*value) + rows[k - 2].*value).cwiseAbs2();
  }
  const double steps = static_cast<double>(last - first - 1);
  const double dt_s = (rows[last - 1].t_s - rows[first].t_s) / steps;
  return std::sqrt(sum.maxCoeff() / (kWhiteNoiseFactor * (steps - 1.0)) * dt_s);
}

}  // namespace

WhiteNoiseDensities EstimateWhiteNoise(const ImuData& imu) {
  const std::vector<ImuSample> rows = OwnRows(imu.samples);
  std::vector<double> gyro, accel;
  for (std::size_t first = 0, last = 0; first < rows.size(); first = last) {
    while (last < rows.size() && rows[last].t_s < rows[first].t_s + kWindowS) ++last;
    if (last - first < kLeastRows) continue;
    gyro.push_back(Density(rows, first, last, &ImuSample::w_ib_b_radps));
    accel.push_back(Density(rows, first, last, &ImuSample::f_b_mps2));
  }
  if (gyro.empty()) return {};
  return {Median(gyro), Median(accel)};
}

}  // namespace dn
