#pragma once

#include <dn/factor.h>

#include <Eigen/Core>

namespace dn::testing {

/// r = (b - a - z) / sigma.
struct Step : AutoFactor<Step, 3, Vec<3>, Vec<3>> {
  Eigen::Vector3d z = Eigen::Vector3d::Zero();
  double sigma = 1.0;
  template <class T>
  bool Residual(const T* a, const T* b, T* r) const {
    for (int i = 0; i < 3; ++i) r[i] = (b[i] - a[i] - z[i]) / sigma;
    return true;
  }
};

}  // namespace dn::testing
