#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace dn {

/// A numerical derivative with an estimate of its error, component by component.
struct NumericalDerivative {
  Eigen::VectorXd value;
  Eigen::VectorXd error;
};

/// Returns the derivative of `f(step)`, a function of one number that returns an Eigen vector, at
/// step = 0. Central differences over shrinking steps are extrapolated to step 0 (Ridders); each
/// component keeps the value with the smallest estimated error. Values that are not finite count
/// as an infinite error.
template <class Function>
NumericalDerivative RiddersDerivative(const Function& f, double first_step) {
  constexpr int kSteps = 8;
  constexpr double kShrink = 2.0, kShrink2 = kShrink * kShrink;
  std::vector<Eigen::VectorXd> before, row;
  NumericalDerivative best;
  double step = first_step;
  for (int i = 0; i < kSteps; ++i, step /= kShrink) {
    row.assign(1, (f(step) - f(-step)) / (2.0 * step));
    if (i == 0) {
      best.value = row[0];
      best.error.setConstant(row[0].size(), std::numeric_limits<double>::infinity());
    }
    double factor = kShrink2;
    for (int j = 1; j <= i; ++j, factor *= kShrink2) {
      const auto k = static_cast<std::size_t>(j - 1);
      row.push_back((row[k] * factor - before[k]) / (factor - 1.0));
      const Eigen::VectorXd& now = row.back();
      for (Eigen::Index c = 0; c < now.size(); ++c) {
        const double error =
            std::max(std::abs(now[c] - row[k][c]), std::abs(now[c] - before[k][c]));
        if (error < best.error[c]) {
          best.error[c] = error;
          best.value[c] = now[c];
        }
      }
    }
    before = row;
  }
  return best;
}

}  // namespace dn
