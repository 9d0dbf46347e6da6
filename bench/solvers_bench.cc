/// Covariances of the network of a simulated flight: assembly, factorisation and selected inverse,
/// with ceres::Covariance for comparison on the smallest flight. Also the solution with and without
/// Ceres.
#include <benchmark/benchmark.h>
#include <dn/builder/flight_network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ceres_covariance.h"
#include "flight_networks.h"

namespace dn::bench {
namespace {

constexpr unsigned kCeresLimit_s = 60;
constexpr double kNodeRate_hz = 5.0;
constexpr double kSparseRate_hz = 1.0;

/// Returns the network of a size, which is created once.
FlightNetwork& BuildNetwork(const std::string& size, double rate_hz = kNodeRate_hz) {
  static std::map<std::pair<std::string, double>, std::unique_ptr<FlightAtTruth>> flights;
  std::unique_ptr<FlightAtTruth>& flight = flights[{size, rate_hz}];
  if (!flight) flight = MakeFlightAtTruth(size, rate_hz);
  return *flight->network;
}

std::vector<BlockId> NodeBlockIds(const FlightNetwork& network) {
  std::vector<BlockId> ids;
  for (const NodeBlocks& node : network.nodes()) {
    ids.insert(ids.end(), {node.q_mb.id, node.p_mb.id, node.v_m.id});
  }
  return ids;
}

void BM_Marginals(benchmark::State& state, const std::string& size, int threads) {
  const FlightNetwork& network = BuildNetwork(size);
  for (auto _ : state) {
    Marginals marginals(network.net(), {.threads = threads});
    marginals.ComputeSelectedInverse();
    const Marginals::Timings& t = marginals.timings();
    state.counters["assemble_s"] = t.assemble_s;
    state.counters["analyze_s"] = t.analyze_s;
    state.counters["factor_s"] = t.factor_s;
    state.counters["selected_inverse_s"] = t.selected_inverse_s;
    state.counters["parameters"] = marginals.num_parameters();
    state.counters["nonzeros_of_L"] = static_cast<double>(marginals.factor_nonzeros());
  }
  state.counters["nodes"] = static_cast<double>(network.nodes().size());
  state.counters["pairs"] = static_cast<double>(network.pairs().edges().size());
}
BENCHMARK_CAPTURE(BM_Marginals, 5min, "5min", 1)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(BM_Marginals, 5min_two_threads, "5min", 2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(BM_Marginals, 20min, "20min", 1)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(BM_Marginals, 20min_two_threads, "20min", 2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();
BENCHMARK_CAPTURE(BM_Marginals, 60min, "60min", 1)->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(BM_Marginals, 60min_two_threads, "60min", 2)
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// Solves from the truth to the adjusted values, with undamped steps and one analysis, or with all
/// steps by Ceres.
void BM_Solve(benchmark::State& state, const std::string& size, bool undamped) {
  const Network& truth = BuildNetwork(size, kSparseRate_hz).net();
  for (auto _ : state) {
    state.PauseTiming();
    Network net(truth);
    state.ResumeTiming();
    const SolveSummary summary = Solve(net, {.function_tolerance = 1e-13,
                                             .sigma_tolerance = 1e-3,
                                             .initial_trust_region_radius = 1e13,
                                             .start_undamped = undamped,
                                             .second_attempt = false});
    if (!summary.converged) state.SkipWithError(summary.message.c_str());
    state.counters["iterations"] = summary.iterations;
    state.counters["cost"] = summary.final_cost;
    state.counters["parameters"] = summary.adjusted.parameters;
  }
}
BENCHMARK_CAPTURE(BM_Solve, 20min, "20min", true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Solve, 20min_by_ceres, "20min", false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Solve, 60min, "60min", true)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_Solve, 60min_by_ceres, "60min", false)->Unit(benchmark::kMillisecond);

/// Returns the blocks of the smallest flight whose covariances are requested.
std::vector<BlockId> Wanted(const FlightNetwork& network, bool all_nodes) {
  if (all_nodes) return NodeBlockIds(network);
  return {network.calibration().boresight().id};
}

/// Computes the same covariances with Marginals; uses the selected inverse only for many blocks.
std::vector<Eigen::MatrixXd> ByMarginals(const Network& net, const std::vector<BlockId>& blocks) {
  Marginals marginals(net);
  if (blocks.size() > 1) marginals.ComputeSelectedInverse();
  std::vector<Eigen::MatrixXd> covariance;
  for (const BlockId b : blocks) covariance.push_back(marginals.Covariance(b));
  return covariance;
}

void BM_WantedByMarginals(benchmark::State& state, bool all_nodes) {
  const FlightNetwork& network = BuildNetwork("5min");
  const std::vector<BlockId> blocks = Wanted(network, all_nodes);
  for (auto _ : state) benchmark::DoNotOptimize(ByMarginals(network.net(), blocks).size());
}
BENCHMARK_CAPTURE(BM_WantedByMarginals, boresight, false)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_WantedByMarginals, all_nodes, true)->Unit(benchmark::kMillisecond);

void BM_WantedByCeres(benchmark::State& state, bool all_nodes) {
  FlightNetwork& network = BuildNetwork("5min");
  const std::vector<BlockId> blocks = Wanted(network, all_nodes);
  for (auto _ : state) {
    const CeresCovariance ceres = ComputeByCeres(network.net(), blocks, kCeresLimit_s);
    if (!ceres.error.empty()) {
      state.SkipWithError(ceres.error.c_str());
      return;
    }
    state.SetIterationTime(ceres.time_s);
    const double difference =
        LargestDifference(ceres.covariance, ByMarginals(network.net(), blocks));
    state.counters["difference"] = difference;
    if (!(difference < kSameCovariance)) state.SkipWithError("the covariances differ");
  }
}
BENCHMARK_CAPTURE(BM_WantedByCeres, boresight, false)
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(BM_WantedByCeres, all_nodes, true)
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dn::bench
