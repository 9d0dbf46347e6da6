// A Gaussian prior: what is known about an unknown before it is measured.
//
// Two distances do not determine a place. An earlier survey gives it with a covariance, which is a
// factor like any other. Prints the message without the prior, and the sigmas with it. Fails unless
// the covariance is (P^-1 + sum u u^T / sigma^2)^-1, with P the prior and u the directions.
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cstdio>

int main() {
  constexpr double kSigma_m = 0.02;
  const Eigen::Vector3d known_m(40.3, 39.8, 90.6);
  Eigen::Matrix3d P;  // of the earlier survey: half a metre, east and north correlated
  P << 0.25, 0.10, 0.00, 0.10, 0.25, 0.00, 0.00, 0.00, 0.36;

  dn::Network net;
  const auto place = net.AddVector<3>("place", known_m);
  const Eigen::Vector3d stations_m[] = {{0, 0, 0}, {100, 0, 0}};
  const double measured_m[] = {106.30, 115.32};
  for (int i = 0; i < 2; ++i) {
    net.Add(
        [s = stations_m[i], d = measured_m[i]](const auto& p_m) { return (p_m - s).norm() - d; },
        dn::Noise<1>::Sigma(kSigma_m), place);
  }
  try {
    const dn::Marginals marginals(net);
    return 1;
  } catch (const dn::RankDeficient& error) {
    std::printf("without the prior, %s\n", error.what());
  }

  net.Add([=](const auto& p_m) { return (p_m - known_m).eval(); }, dn::Noise<3>::Covariance(P),
          place);
  const bool converged = dn::Solve(net).converged;
  const Eigen::Matrix3d C = dn::MarginalCovariance(net, place);
  for (int i = 0; i < 3; ++i) {
    std::printf("%c %.2f m, sigma %.2f m; the prior alone %.2f m, sigma %.2f m\n", "xyz"[i],
                net.Value(place)[i], std::sqrt(C(i, i)), known_m[i], std::sqrt(P(i, i)));
  }

  Eigen::Matrix3d information = P.inverse();
  for (const Eigen::Vector3d& s : stations_m) {
    const Eigen::Vector3d u = (net.Value(place) - s).normalized();
    information += u * u.transpose() / (kSigma_m * kSigma_m);
  }
  const double difference = (C - information.inverse()).norm() / C.norm();
  std::printf("difference from the theory %.0e\n", difference);
  return converged && difference < 1e-9 ? 0 : 1;
}
