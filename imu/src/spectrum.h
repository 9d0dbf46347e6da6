#pragma once

#include <dn/imu/imu_data.h>

#include <array>
#include <cstddef>
#include <vector>

namespace dn {

/// One-sided power density of the six axes (gyro, then accelerometer) at multiples of step_hz.
struct ImuSpectrum {
  static constexpr std::size_t kAxes = 6;

  double step_hz = 0.0;
  std::array<std::vector<double>, kAxes> density;
};

/// Number of samples in a part of a record.
inline constexpr std::size_t kSpectrumSamples = 512;

/// Returns the first samples of the parts of a record: kSpectrumSamples at equal intervals. At most
/// 300 parts are returned, spread evenly; none if there are fewer than three.
std::vector<std::size_t> SpectrumParts(const ImuData& imu);

/// Returns the spectrum of a part, with a Hann window.
ImuSpectrum PartSpectrum(const ImuData& imu, std::size_t first);

/// Returns the mean spectrum of several parts, at least one.
ImuSpectrum MeanSpectrum(const ImuData& imu, const std::vector<std::size_t>& parts);

/// Returns the lowest level of a mean spectrum from the step `first` on: white noise without lines
/// and resonances. The level is a low quantile, corrected for white noise.
double WhiteFloor(const std::vector<double>& density, std::size_t first, std::size_t num_parts);

}  // namespace dn
