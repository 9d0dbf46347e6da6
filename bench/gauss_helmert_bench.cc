// Time and memory of the Gauss-Helmert adjustment by number of pairs. "added_MiB" is the peak
// memory during the adjustment minus the memory before it. The memory of the pairs is therefore not
// included.

#include <benchmark/benchmark.h>
#include <dn/fixed_trajectory/gauss_helmert.h>
#include <dn/fixed_trajectory/trajectory_scatter.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <string>

#include "testing/strip_pairs.h"

namespace dn::bench {
namespace {

/// Returns a value of /proc/self/status in MiB.
double StatusMib(const std::string& key) {
  std::ifstream status("/proc/self/status");
  std::string line;
  while (std::getline(status, line)) {
    if (line.rfind(key + ":", 0) == 0) return std::stod(line.substr(key.size() + 1)) / 1024.0;
  }
  return 0.0;
}

void ForgetPeak() { std::ofstream("/proc/self/clear_refs") << "5"; }

GaussHelmertProblem NoisyPairs(int count) {
  testing::StripPairOptions options;
  options.count = count;
  GaussHelmertProblem problem = testing::MakeStripPairs(options);
  std::mt19937 rng(1);
  testing::Disturb(&problem, testing::WhiteErrors(rng), options.sigma_p_m, rng);
  return problem;
}

void BM_AdjustGaussHelmert(benchmark::State& state) {
  const GaussHelmertProblem problem = NoisyPairs(static_cast<int>(state.range(0)));
  double added_mib = 0.0;
  int iterations = 0;
  for (auto _ : state) {
    const double before_mib = StatusMib("VmRSS");
    ForgetPeak();
    const GaussHelmertResult result = AdjustGaussHelmert(problem);
    added_mib = std::max(added_mib, StatusMib("VmHWM") - before_mib);
    iterations = result.iterations;
  }
  state.counters["iterations"] = iterations;
  state.counters["added_MiB"] = added_mib;
  state.counters["peak_MiB"] = StatusMib("VmHWM");
}
BENCHMARK(BM_AdjustGaussHelmert)
    ->Arg(5000)
    ->Arg(50000)
    ->Arg(1000000)
    ->Unit(benchmark::kMillisecond);

void BM_TrajectoryScatter(benchmark::State& state) {
  const GaussHelmertProblem problem = NoisyPairs(static_cast<int>(state.range(0)));
  const GaussHelmertResult result = AdjustGaussHelmert(problem);
  TrajectoryErrorOptions options;
  options.sigma_ned_m = problem.pairs.front().i.sigma_ned_m;
  options.sigma_rph_rad = problem.pairs.front().i.sigma_rph_rad;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        EstimateCorrelatedErrorCovariance(problem, result, BoresightModel::kExponential, options));
  }
}
BENCHMARK(BM_TrajectoryScatter)->Arg(5000)->Arg(50000)->Arg(1000000)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dn::bench
