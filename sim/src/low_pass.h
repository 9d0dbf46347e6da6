#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <array>

namespace dn {

/// Butterworth low-pass of order four for rates and specific forces, sampled evenly:
///
///   |H(f)|^2 = 1 / (1 + (f / cut_off)^8)
///
/// It is the bilinear transform of the analogue filter, exact at the cut-off frequency.
class LowPass {
 public:
  /// Rates in rows 0..2, forces in rows 3..5.
  using Vector = Eigen::Matrix<double, 6, 1>;

  /// Throws InvalidInput unless 0 < cut_off_hz < rate_hz / 2. `first` is the value before the first
  /// sample.
  LowPass(double cut_off_hz, double rate_hz, const Vector& first);

  /// Takes a sample and returns the filtered one.
  Vector Next(const Vector& sample);

  /// Returns the delay of slow signals, 2.613 / (2 pi cut_off) for high rates.
  static double Delay(double cut_off_hz, double rate_hz);

 private:
  /// Section of order two, in transposed direct form II.
  struct Section {
    double b0, a1, a2;
    Vector first, second;
  };
  std::array<Section, 2> sections_;
};

}  // namespace dn
