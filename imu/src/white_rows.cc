#include <dn/imu/white_rows.h>
#include <dn/median.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "spectrum.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kWindowS = 1.0;
constexpr std::size_t kLeastRows = 5;
constexpr double kCalmShare = 0.1, kMostRepeatedRows = 0.05;
constexpr std::size_t kFewestCalm = 3;
// Mean power of the upper half of a spectrum divided by its floor, up to which it counts as white.
constexpr double kWhitePower = 1.5;

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

WhiteNoiseDensities ByDifferences(const ImuData& imu) {
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

/// Returns the mean density of the upper half of the frequencies.
double UpperMean(const std::vector<double>& density) {
  const auto middle = density.begin() + static_cast<std::ptrdiff_t>(density.size() / 2);
  double sum = 0.0;
  for (auto it = middle; it != density.end(); ++it) sum += *it;
  return sum / static_cast<double>(density.end() - middle);
}

/// Returns the parts with the least power of all axes in the upper half of the frequencies.
std::vector<std::size_t> CalmParts(const ImuData& imu, const std::vector<std::size_t>& parts) {
  std::vector<Eigen::Matrix<double, ImuSpectrum::kAxes, 1>> powers;
  Eigen::Matrix<double, ImuSpectrum::kAxes, 1> mean;
  mean.setZero();
  for (const std::size_t part : parts) {
    const ImuSpectrum spectrum = PartSpectrum(imu, part);
    powers.emplace_back();
    for (std::size_t axis = 0; axis < ImuSpectrum::kAxes; ++axis) {
      powers.back()[static_cast<Eigen::Index>(axis)] = UpperMean(spectrum.density[axis]);
    }
    mean += powers.back() / static_cast<double>(parts.size());
  }
  std::vector<std::pair<double, std::size_t>> sorted;
  for (std::size_t k = 0; k < parts.size(); ++k) {
    sorted.emplace_back(powers[k].cwiseQuotient(mean.cwiseMax(1e-300)).sum(), parts[k]);
  }
  std::sort(sorted.begin(), sorted.end());
  const auto share = static_cast<std::size_t>(kCalmShare * static_cast<double>(parts.size()));
  std::vector<std::size_t> calm;
  for (std::size_t k = 0; k < std::max(kFewestCalm, share); ++k) calm.push_back(sorted[k].second);
  return calm;
}

WhiteNoiseDensities BySpectrum(const ImuData& imu, const std::vector<std::size_t>& parts) {
  const std::vector<std::size_t> calm = CalmParts(imu, parts);
  const ImuSpectrum spectrum = MeanSpectrum(imu, calm);
  double mean[2] = {0.0, 0.0}, floor[2] = {0.0, 0.0};
  WhiteNoiseDensities noise;
  for (std::size_t axis = 0; axis < ImuSpectrum::kAxes; ++axis) {
    const std::vector<double>& density = spectrum.density[axis];
    const double level = WhiteFloor(density, density.size() / 2, calm.size());
    const double power = UpperMean(density);
    noise.shaking = noise.shaking || power > kWhitePower * level;
    mean[axis / 3] = std::max(mean[axis / 3], power);
    floor[axis / 3] = std::max(floor[axis / 3], level);
  }
  const double* used = noise.shaking ? floor : mean;
  // The density is one-sided.
  noise.gyro_rad_per_sqrt_s = std::sqrt(0.5 * used[0]);
  noise.accel_mps_per_sqrt_s = std::sqrt(0.5 * used[1]);
  return noise;
}

}  // namespace

WhiteNoiseDensities EstimateWhiteNoise(const ImuData& imu) {
  const auto repeated = static_cast<double>(imu.repeated_values);
  if (repeated > kMostRepeatedRows * static_cast<double>(imu.samples.size()))
    return ByDifferences(imu);
  const std::vector<std::size_t> parts = SpectrumParts(imu);
  return parts.empty() ? ByDifferences(imu) : BySpectrum(imu, parts);
}

}  // namespace dn
