// Fifty designs of a distance network: where should the fourth station stand? Nothing is measured,
// and nothing is solved.
#include <dn/solvers/marginals.h>

#include <vector>

#include "check.h"

namespace {

const Eigen::Vector3d kPoint_m(40.0, 30.0, 20.0);

dn::Network Design(const Eigen::Vector3d& fourth_m) {
  dn::Network net;
  const auto point = net.AddVector<3>("point", kPoint_m);
  for (const Eigen::Vector3d& station_m : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(100, 0, 0),
                                           Eigen::Vector3d(0, 100, 2), fourth_m}) {
    net.Add([=](const auto& p) { return (p - station_m).norm(); }, dn::Noise<1>::Sigma(0.01),
            point);
  }
  return net;
}

double HeightSigma(const Eigen::Vector3d& fourth_m) {
  const dn::Network net = Design(fourth_m);
  return dn::MarginalSigma(net, net.Find<dn::Vec<3>>("point")).z();
}

/// Computes the same by hand.
double ExpectedHeightSigma(const Eigen::Vector3d& fourth_m) {
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& station_m : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(100, 0, 0),
                                           Eigen::Vector3d(0, 100, 2), fourth_m}) {
    const Eigen::Vector3d u = (kPoint_m - station_m).normalized();
    N += u * u.transpose() / (0.01 * 0.01);
  }
  return std::sqrt(N.inverse()(2, 2));
}

}  // namespace

int main() {
  bool good = true;
  double best_m = 1.0;
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  for (int k = 0; k < 50; ++k) {
    const Eigen::Vector3d fourth_m(10.0 * (k % 10), 20.0 * (k / 10), 5.0 * (k % 5));
    const double sigma_m = HeightSigma(fourth_m);
    const double expected_m = ExpectedHeightSigma(fourth_m);
    if (std::abs(sigma_m - expected_m) > 1e-9 * expected_m) {
      good = Between("sigma", sigma_m, expected_m, expected_m);
    }
    if (sigma_m < best_m) {
      best_m = sigma_m;
      best = fourth_m;
    }
  }
  std::printf("best fourth station %g %g %g m\n", best.x(), best.y(), best.z());
  return Between("its sigma, m", best_m, 0.001, 0.02) && good ? 0 : 1;
}
