// A user's own network: a levelling line adjusted by least squares.
//
// There are four benchmarks A, B, C, D, and A is known. Five levelled height differences close two
// loops. Prints every height with its standard deviation, and the error message without the known
// benchmark.
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cstdio>

int main() {
  dn::Network net;
  const auto a = net.AddScalar("A", 100.0), b = net.AddScalar("B", 0.0),
             c = net.AddScalar("C", 0.0), d = net.AddScalar("D", 0.0);
  const auto level = [&](auto from, auto to, double difference_m) {
    net.Add([=](const auto& h_from, const auto& h_to) { return h_to - h_from - difference_m; },
            dn::Noise<1>::Sigma(0.002), from, to);
  };
  level(a, b, 1.002);
  level(b, c, 1.501);
  level(c, d, -0.498);
  level(d, a, -2.001);
  level(a, c, 2.506);
  net.Hold(a);

  const dn::SolveSummary summary = dn::Solve(net);
  const dn::Marginals marginals(net);
  for (const auto h : {b, c, d}) {
    std::printf("%s  height %.4f m  sigma %.2f mm\n", net.block(h.id).name.c_str(), net.Value(h),
                1e3 * marginals.Sigma(h));
  }
  std::printf("sigma0 %.2f of %ld redundant\n", summary.adjusted.sigma0(),
              summary.adjusted.redundancy());

  net.Hold(a, false);
  try {
    std::printf("sigma of B %.3f m\n", dn::MarginalSigma(net, b));
  } catch (const dn::RankDeficient& error) {
    std::printf("%s\n", error.what());
  }
  return summary.converged ? 0 : 1;
}
