// Calibration values as unknowns: offset and scale of a range finder, from the distances between
// six pillars on a line. The positions of the pillars are also unknown, but one length is known.
//
// Prints offset and scale with sigmas and correlation, and the directions that the distances leave
// undetermined without the known length.
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

int main() {
  constexpr double kOffset_m = 0.035, kScale = 1.0 + 12e-6, kSigma_m = 0.0005;
  const std::vector<double> truth_m{0.0, 90.0, 210.0, 430.0, 590.0, 800.0};
  dn::Network net;
  const auto offset = net.AddScalar("offset", 0.0), scale = net.AddScalar("scale", 1.0);
  std::vector<dn::Block<dn::Scalar>> pillars;
  for (std::size_t i = 0; i < truth_m.size(); ++i) {
    pillars.push_back(net.AddScalar("pillar " + std::to_string(i), truth_m[i] + 0.1));
  }
  net.SetValue(pillars[0], 0.0);
  net.Hold(pillars[0]);
  for (std::size_t i = 0; i < truth_m.size(); ++i) {
    for (std::size_t j = i + 1; j < truth_m.size(); ++j) {
      const double error_m =
          kSigma_m * std::sin(7.0 * static_cast<double>(i) + 3.0 * static_cast<double>(j));
      const double range_m = kOffset_m + kScale * (truth_m[j] - truth_m[i]) + error_m;
      net.Add([=](const auto& o, const auto& s, const auto& from,
                  const auto& to) { return o + s * (to - from) - range_m; },
              dn::Noise<1>::Sigma(kSigma_m), offset, scale, pillars[i], pillars[j]);
    }
  }
  const dn::FactorId known = net.Add([&](const auto& last) { return last - truth_m.back(); },
                                     dn::Noise<1>::Sigma(0.001), pillars.back());

  const dn::SolveSummary summary = dn::Solve(net);
  const dn::Marginals marginals(net);
  const double sigma_o = marginals.Sigma(offset);
  const double sigma_s = marginals.Sigma(scale);
  std::printf("offset %.2f mm, sigma %.2f mm (truth %.2f)\n", 1e3 * net.Value(offset),
              1e3 * sigma_o, 1e3 * kOffset_m);
  std::printf("scale %.2f ppm, sigma %.2f ppm (truth %.2f)\n", 1e6 * (net.Value(scale) - 1.0),
              1e6 * sigma_s, 1e6 * (kScale - 1.0));
  std::printf("correlation %.2f, sigma0 %.2f\n",
              marginals.Covariance(offset, scale)(0, 0) / (sigma_o * sigma_s),
              summary.adjusted.sigma0());

  net.RemoveFactor(known);
  try {
    const dn::Marginals without(net);
  } catch (const dn::RankDeficient& error) {
    std::printf("without the known length, %s\n", error.what());
  }
  return summary.converged ? 0 : 1;
}
