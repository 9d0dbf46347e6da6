#pragma once

#include <dn/network.h>

#include <cmath>

namespace dn {

/// rho(s) and rho'(s) of a robust loss at the squared norm s; Huber and Cauchy equal
/// ceres::HuberLoss and ceres::CauchyLoss. Second derivatives are never positive, so the weight of
/// a factor in the normal matrix is rho' alone.
struct LossValue {
  double rho = 0.0;
  double rho_prime = 1.0;
};

inline LossValue EvaluateLoss(const Loss& loss, double s) {
  const double width2 = loss.width * loss.width;
  switch (loss.type) {
    case Loss::Type::kHuber: {
      if (s <= width2) return {s, 1.0};
      const double r = std::sqrt(s);
      return {2.0 * loss.width * r - width2, loss.width / r};
    }
    case Loss::Type::kCauchy:
      return {width2 * std::log1p(s / width2), 1.0 / (1.0 + s / width2)};
    case Loss::Type::kFunction: {
      const auto [rho, rho_prime] = (*loss.function)(s);
      return {rho, rho_prime};
    }
    case Loss::Type::kNone:
      break;
  }
  return {s, 1.0};
}

}  // namespace dn
