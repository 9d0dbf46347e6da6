#include <dn/adjustment/achieved_accuracy.h>
#include <dn/geo/local_frame.h>
#include <dn/quantile.h>

namespace dn {
namespace {

using Axes = Eigen::Vector3d TrajectorySigma::*;

Eigen::Vector3d AxisQuantiles(const std::vector<TrajectorySigma>& sigma, Axes axes, double p) {
  Eigen::Vector3d quantile;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> values;
    for (const TrajectorySigma& node : sigma) values.push_back((node.*axes)[axis]);
    quantile[axis] = Quantile(std::move(values), p);
  }
  return quantile;
}

}  // namespace

AchievedAccuracy SummariseAccuracy(const std::vector<TrajectorySigma>& sigma) {
  AchievedAccuracy accuracy;
  for (const Axes axes : {&TrajectorySigma::position_enu_m, &TrajectorySigma::velocity_enu_mps,
                          &TrajectorySigma::rph_rad}) {
    accuracy.median.*axes = AxisQuantiles(sigma, axes, 0.5);
    accuracy.largest.*axes = AxisQuantiles(sigma, axes, 1.0);
  }
  return accuracy;
}

Json AccuracyJson(const AchievedAccuracy& accuracy) {
  return {{"median_enu_m", ToJson(accuracy.median.position_enu_m)},
          {"largest_enu_m", ToJson(accuracy.largest.position_enu_m)},
          {"median_rph_deg", ToJson(Eigen::Vector3d(accuracy.median.rph_rad * kDegPerRad))},
          {"largest_rph_deg", ToJson(Eigen::Vector3d(accuracy.largest.rph_rad * kDegPerRad))}};
}

}  // namespace dn
