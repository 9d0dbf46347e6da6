// Groups and time tags: which sensor contradicts its noise, and when.
//
// Two gauges record a rising water level for two hours. Gauge B has twice its stated noise, and is
// wrong by 10 cm at one epoch. Tag gives each reading its group and time, which the tests of the
// fit then name. Fails unless they name the gauge, its noise and the epoch.
#include <dn/network.h>
#include <dn/solvers/fit_check.h>
#include <dn/solvers/solve.h>

#include <cmath>
#include <cstdio>
#include <random>

dn::FitCheck SolveAndCheck(dn::Network& net) {
  if (!dn::Solve(net).converged) std::printf("not converged\n");
  dn::Marginals marginals(net);
  marginals.ComputeSelectedInverse();
  return dn::CheckFit(marginals);
}

int main() {
  constexpr double kSigma_m = 0.01, kWrong_s = 4320.0;
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  dn::Network net;
  const auto level = net.AddScalar("level", 0.0), rate = net.AddScalar("rate", 0.0);
  const auto read = [&](const char* gauge, double t_s, double error_m) {
    const double reading_m = 1.5 + 1e-4 * t_s + error_m;
    const dn::FactorId id =
        net.Add([=](const auto& h, const auto& v) { return h + v * t_s - reading_m; },
                dn::Noise<1>::Sigma(kSigma_m), level, rate);
    net.Tag(id, {"level", {{"up"}}, gauge}, t_s);  // name, names of the rows, sensor
  };
  for (double t_s = 0.0; t_s < 7200.0; t_s += 60.0) {
    read("gauge A", t_s, kSigma_m * normal(random));
    read("gauge B", t_s, 2.0 * kSigma_m * normal(random) + (t_s == kWrong_s ? 0.1 : 0.0));
  }

  const dn::RowFit worst = SolveAndCheck(net).worst;
  std::printf("largest residual: %s %s at %.0f s, w = %.1f\n", worst.row.channel.c_str(),
              worst.row.axis.c_str(), worst.row.t_s, worst.standardised);
  const bool found = worst.row.channel == "gauge B level" && worst.row.t_s == kWrong_s;
  net.RemoveFactor(worst.row.factor);

  bool right = true;
  for (const dn::ChannelFit& channel : SolveAndCheck(net).channels) {
    if (channel.name.ends_with(" up")) continue;  // each row is a channel, too
    const double noise = std::sqrt(channel.variance_ratio);
    const double truth = channel.name.starts_with("gauge A") ? 1.0 : 2.0;
    std::printf("%s: noise %.2f times the stated one, p = %.2g\n", channel.name.c_str(), noise,
                channel.p_value);
    const double sigma = truth / std::sqrt(2.0 * channel.redundancy);
    right = right && std::abs(noise - truth) < 4.0 * sigma;
  }
  return found && right ? 0 : 1;
}
