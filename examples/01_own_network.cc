// An own network: a levelling line adjusted by least squares.
//
// Four benchmarks A, B, C, D; A is known. Five levelled height differences close two loops, so that
// every height has a standard deviation. Prints them, and what is said without the known benchmark.
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cmath>
#include <cstdio>

using Height = dn::Vec<1>;

/// r = (h_to - h_from - difference) / sigma      [1], unitless; h, difference, sigma in m
struct Levelling : dn::AutoFactor<Levelling, 1, Height, Height> {
  double difference_m = 0.0, sigma_m = 0.001;

  template <class T>
  bool Residual(const T* h_from, const T* h_to, T* r) const {
    r[0] = (h_to[0] - h_from[0] - difference_m) / sigma_m;
    return true;
  }
};

int main() {
  dn::Network net;
  const auto benchmark = [&](const char* name, double height_m) {
    return net.AddVector<1>(name, Eigen::Matrix<double, 1, 1>(height_m));
  };
  const auto a = benchmark("A", 100.0), b = benchmark("B", 0.0), c = benchmark("C", 0.0),
             d = benchmark("D", 0.0);
  const auto level = [&](dn::Block<Height> from, dn::Block<Height> to, double difference_m) {
    Levelling f;
    f.difference_m = difference_m;
    f.sigma_m = 0.002;
    net.Add(f, from, to);
  };
  level(a, b, 1.002);
  level(b, c, 1.501);
  level(c, d, -0.498);
  level(d, a, -2.001);
  level(a, c, 2.506);
  net.Hold(a);

  const dn::SolveReport report = dn::Solve(net);
  const dn::Marginals marginals(net);
  for (const auto& h : {b, c, d}) {
    std::printf("%s  height %.4f m  sigma %.2f mm\n", net.block(h.id).name.c_str(), net.Value(h)[0],
                1e3 * std::sqrt(marginals.Covariance(h)(0, 0)));
  }

  net.Hold(a, false);
  try {
    std::printf("sigma of B %.3f m\n", std::sqrt(dn::MarginalCovariance(net, b)(0, 0)));
  } catch (const dn::RankDeficient& error) {
    std::printf("%s\n", error.what());
  }
  return report.converged ? 0 : 1;
}
