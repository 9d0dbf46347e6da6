/// Covariances of every pose of a pose graph on a sphere, computed by Marginals and, for
/// comparison, by ceres::Covariance.
#include <benchmark/benchmark.h>
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cmath>
#include <string>
#include <vector>

#include "ceres_covariance.h"

namespace dn::bench {
namespace {

constexpr unsigned kCeresLimit_s = 400;

struct PoseGraph {
  Network net;
  std::vector<BlockId> poses;
};

/// Returns poses on parallels of a sphere, each connected to the next on its parallel and to the
/// one on the parallel below. The first pose is constant. The values are the truth, so no solution
/// is needed.
PoseGraph MakeSphere(int parallels, int poses_of_each) {
  PoseGraph graph;
  std::vector<Block<Pose>> blocks;
  for (int i = 0; i < parallels * poses_of_each; ++i) {
    const double turn = 2.0 * M_PI * i / poses_of_each;
    const double height = 1.8 * i / (parallels * poses_of_each) - 0.9;
    const double radius = 50.0 * std::sqrt(1.0 - height * height);
    const Transform<double> T(
        Exp(Eigen::Vector3d(0.0, 0.0, turn)) * Exp(Eigen::Vector3d(0.0, height, 0.0)),
        {radius * std::cos(turn), radius * std::sin(turn), 50.0 * height});
    blocks.push_back(graph.net.AddPose(std::to_string(i), T));
    graph.poses.push_back(blocks.back().id);
  }
  graph.net.Hold(blocks[0]);
  Eigen::Matrix<double, 6, 1> sigma;
  sigma << 0.01, 0.01, 0.01, 0.05, 0.05, 0.05;
  const auto tie = [&](int i, int j) {
    const auto from = blocks[static_cast<std::size_t>(i)], to = blocks[static_cast<std::size_t>(j)];
    const Transform<double> T_ji =
        (graph.net.Value(from).Inverse() * graph.net.Value(to)).Inverse();
    const auto relative = [=](const auto& T_mi, const auto& T_mj) {
      return (T_ji * T_mi.Inverse() * T_mj).ToVector();
    };
    graph.net.Add(relative, Noise<6>::Sigma(sigma), from, to);
  };
  for (int i = 1; i < parallels * poses_of_each; ++i) {
    tie(i - 1, i);
    if (i >= poses_of_each) tie(i - poses_of_each, i);
  }
  return graph;
}

std::vector<Eigen::MatrixXd> ByMarginals(const PoseGraph& graph) {
  Marginals marginals(graph.net);
  marginals.ComputeSelectedInverse();
  std::vector<Eigen::MatrixXd> covariance;
  for (std::size_t k = 1; k < graph.poses.size(); ++k) {
    covariance.push_back(marginals.Covariance(graph.poses[k]));
  }
  return covariance;
}

void BM_AllPosesByMarginals(benchmark::State& state) {
  const PoseGraph graph = MakeSphere(static_cast<int>(state.range(0)), 50);
  for (auto _ : state) benchmark::DoNotOptimize(ByMarginals(graph).size());
  state.counters["poses"] = static_cast<double>(graph.poses.size());
}
BENCHMARK(BM_AllPosesByMarginals)->Arg(2)->Arg(8)->Arg(20)->Arg(50)->Unit(benchmark::kMillisecond);

/// Solves from displaced poses and computes the covariance of every pose.
void BM_SolveAndAllPoses(benchmark::State& state) {
  constexpr double kDisplacement_m = 0.1;
  PoseGraph graph = MakeSphere(static_cast<int>(state.range(0)), 50);
  for (auto _ : state) {
    for (std::size_t k = 1; k < graph.poses.size(); ++k) {
      double* pose = graph.net.block(graph.poses[k]).value.get();
      pose[4 + k % 3] += kDisplacement_m;
    }
    const SolveSummary summary = Solve(graph.net, {.sigma_tolerance = 1e-3});
    if (!summary.converged) state.SkipWithError(summary.message.c_str());
    benchmark::DoNotOptimize(ByMarginals(graph).size());
  }
  state.counters["poses"] = static_cast<double>(graph.poses.size());
}
BENCHMARK(BM_SolveAndAllPoses)->Arg(100)->Iterations(3)->Unit(benchmark::kMillisecond);

void BM_AllPosesByCeres(benchmark::State& state) {
  PoseGraph graph = MakeSphere(static_cast<int>(state.range(0)), 50);
  const std::vector<BlockId> free(graph.poses.begin() + 1, graph.poses.end());
  for (auto _ : state) {
    const CeresCovariance ceres = ComputeByCeres(graph.net, free, kCeresLimit_s);
    if (!ceres.error.empty()) {
      state.SkipWithError(ceres.error.c_str());
      return;
    }
    state.SetIterationTime(ceres.time_s);
    const double difference = LargestDifference(ceres.covariance, ByMarginals(graph));
    state.counters["difference"] = difference;
    if (!(difference < kSameCovariance)) state.SkipWithError("the covariances differ");
  }
  state.counters["poses"] = static_cast<double>(graph.poses.size());
}
BENCHMARK(BM_AllPosesByCeres)
    ->Arg(2)
    ->Arg(8)
    ->Arg(20)
    ->UseManualTime()
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace dn::bench
