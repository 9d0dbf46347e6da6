#include "spectrum.h"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <utility>

namespace dn {
namespace {

using Complex = std::complex<double>;

/// Replaces the values by their discrete Fourier transform. Their number is a power of two.
void Transform(std::vector<Complex>* x) {
  const std::size_t n = x->size();
  if (n == 1) return;
  std::vector<Complex> even(n / 2), odd(n / 2);
  for (std::size_t k = 0; k < n / 2; ++k) {
    even[k] = (*x)[2 * k];
    odd[k] = (*x)[2 * k + 1];
  }
  Transform(&even);
  Transform(&odd);
  for (std::size_t k = 0; k < n / 2; ++k) {
    const double angle = -2.0 * std::numbers::pi * static_cast<double>(k) / static_cast<double>(n);
    const Complex turned = std::polar(1.0, angle) * odd[k];
    (*x)[k] = even[k] + turned;
    (*x)[k + n / 2] = even[k] - turned;
  }
}

double AxisValue(const ImuSample& sample, std::size_t axis) {
  const auto k = static_cast<Eigen::Index>(axis % 3);
  return axis < 3 ? sample.w_ib_b_radps[k] : sample.f_b_mps2[k];
}

bool FollowsEvenly(const ImuData& imu, std::size_t k) {
  constexpr double kTolerance = 0.5;
  const double step_s = k == 0 ? imu.nominal_dt_s : imu.samples[k].t_s - imu.samples[k - 1].t_s;
  return std::abs(step_s / imu.nominal_dt_s - 1.0) < kTolerance;
}

double Hann(std::size_t k) {
  const double s = std::sin(std::numbers::pi * (static_cast<double>(k) + 0.5) / kSpectrumSamples);
  return s * s;
}

}  // namespace

std::vector<std::size_t> SpectrumParts(const ImuData& imu) {
  constexpr std::size_t kMost = 300, kFewest = 3;
  std::vector<std::size_t> parts;
  for (std::size_t k = 0, first = 0; k < imu.samples.size(); ++k) {
    if (!FollowsEvenly(imu, k)) first = k;
    if (k + 1 - first < kSpectrumSamples) continue;
    parts.push_back(first);
    first = k + 1;
  }
  if (parts.size() < kFewest) return {};
  if (parts.size() <= kMost) return parts;
  std::vector<std::size_t> spread;
  for (std::size_t k = 0; k < kMost; ++k) spread.push_back(parts[k * parts.size() / kMost]);
  return spread;
}

ImuSpectrum PartSpectrum(const ImuData& imu, std::size_t first) {
  constexpr double kHannPower = 0.375;
  const double n = kSpectrumSamples;
  ImuSpectrum spectrum;
  spectrum.step_hz = 1.0 / (n * imu.nominal_dt_s);
  for (std::size_t axis = 0; axis < ImuSpectrum::kAxes; ++axis) {
    double mean = 0.0;
    for (std::size_t k = 0; k < kSpectrumSamples; ++k) {
      mean += AxisValue(imu.samples[first + k], axis) / n;
    }
    std::vector<Complex> x(kSpectrumSamples);
    for (std::size_t k = 0; k < kSpectrumSamples; ++k) {
      x[k] = Hann(k) * (AxisValue(imu.samples[first + k], axis) - mean);
    }
    Transform(&x);
    for (std::size_t k = 0; k < kSpectrumSamples / 2; ++k) {
      spectrum.density[axis].push_back(2.0 * std::norm(x[k]) * imu.nominal_dt_s / (n * kHannPower));
    }
  }
  return spectrum;
}

ImuSpectrum MeanSpectrum(const ImuData& imu, const std::vector<std::size_t>& parts) {
  ImuSpectrum sum = PartSpectrum(imu, parts.front());
  for (std::size_t p = 1; p < parts.size(); ++p) {
    const ImuSpectrum part = PartSpectrum(imu, parts[p]);
    for (std::size_t axis = 0; axis < ImuSpectrum::kAxes; ++axis) {
      for (std::size_t k = 0; k < kSpectrumSamples / 2; ++k) {
        sum.density[axis][k] += part.density[axis][k];
      }
    }
  }
  for (auto& density : sum.density) {
    for (double& value : density) value /= static_cast<double>(parts.size());
  }
  return sum;
}

double WhiteFloor(const std::vector<double>& density, std::size_t first, std::size_t num_parts) {
  // The mean of n exponentially distributed powers has the relative sigma 1/sqrt(n).
  constexpr double kQuantile = 0.2, kNormalDeviate = 0.84, kLeastFactor = 0.3;
  std::vector<double> sorted(density.begin() + static_cast<std::ptrdiff_t>(first), density.end());
  std::sort(sorted.begin(), sorted.end());
  const auto at = static_cast<std::size_t>(kQuantile * static_cast<double>(sorted.size()));
  const double factor = 1.0 - kNormalDeviate / std::sqrt(static_cast<double>(num_parts));
  return sorted[at] / std::max(kLeastFactor, factor);
}

}  // namespace dn
