// A wrong measurement, found by the test of the fit (Baarda's data snooping).
//
// Two instruments measure distances to an antenna; one distance is 15 cm too long. The worst
// distance is removed until the fit agrees with the noise. Prints the p-value of each instrument.
// Fails unless exactly the wrong distance is removed and the antenna is within four sigmas.
#include <dn/network.h>
#include <dn/solvers/fit_check.h>
#include <dn/solvers/solve.h>

#include <cstdio>
#include <random>
#include <vector>

int main() {
  const Eigen::Vector3d truth_m(40.0, 45.0, 60.0);
  const Eigen::Vector3d stations_m[] = {{0, 0, 0},     {100, 0, 0},   {0, 100, 5},
                                        {100, 100, 0}, {50, -40, 30}, {-60, 50, 20}};
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  dn::Network net;
  const auto antenna = net.AddVector<3>("antenna", {30.0, 30.0, 50.0});
  dn::FactorId wrong = -1;
  const auto measure = [&](const char* instrument, double sigma_m) {
    for (const Eigen::Vector3d& s : stations_m) {
      double d_m = (truth_m - s).norm() + sigma_m * normal(random);
      const bool is_wrong = wrong < 0 && sigma_m < 0.02 && s.x() == 50.0;
      if (is_wrong) d_m += 0.15;
      const dn::FactorId id = net.Add([=](const auto& p_m) { return (p_m - s).norm() - d_m; },
                                      dn::Noise<1>::Sigma(sigma_m), antenna);
      net.Tag(id, instrument, 0.0);
      if (is_wrong) wrong = id;
    }
  };
  measure("laser", 0.01);
  measure("tape", 0.03);

  std::vector<dn::FactorId> removed;
  while (removed.size() < 3) {
    if (!dn::Solve(net).converged) return 1;
    dn::Marginals marginals(net);
    marginals.ComputeSelectedInverse();
    const dn::FitCheck fit = dn::CheckFit(marginals);
    for (const dn::ChannelFit& channel : fit.channels) {
      if (channel.name.ends_with(" 0")) continue;  // each row is a channel, too
      std::printf("%-5s  p = %.2g  ", channel.name.c_str(), channel.p_value);
    }
    std::printf("\n");
    if (fit.worst_p_value > 0.001) break;
    removed.push_back(fit.worst.row.factor);
    std::printf("remove %s, w = %.1f\n", net.DescribeFactor(removed.back()).c_str(),
                fit.worst.standardised);
    net.RemoveFactor(removed.back());
  }
  const Eigen::Vector3d error_m = net.Value(antenna) - truth_m;
  const Eigen::Vector3d in_sigmas = error_m.cwiseQuotient(dn::MarginalSigma(net, antenna));
  std::printf("error %.1f %.1f %.1f sigma\n", in_sigmas.x(), in_sigmas.y(), in_sigmas.z());
  return removed == std::vector{wrong} && in_sigmas.cwiseAbs().maxCoeff() < 4.0 ? 0 : 1;
}
