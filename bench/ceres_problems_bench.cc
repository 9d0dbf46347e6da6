/// Covariances of problems of Ceres by dn::Marginals and by ceres::Covariance, in one run. Prints a
/// table in Markdown.
#include <ceres/autodiff_cost_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <dn/ceres.h>
#include <dn/rotation.h>
#include <dn/solvers/marginals.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "ceres_covariance.h"
#include "flight_networks.h"
#include "testing/ceres_errors.h"

namespace dn::bench {
namespace {

using testing::RelativePoseError;
using testing::Reprojection;

constexpr unsigned kCeresLimit_s = 300;
constexpr int kRuns = 5;  // the table has the median
constexpr double kNodeRate_hz = 5.0;

/// Parameter blocks of one problem whose covariances are computed.
struct Wanted {
  std::string problem;
  std::string blocks_name;
  std::vector<const double*> blocks;
};

std::vector<Eigen::MatrixXd> ByMarginals(const ceres::Problem& problem,
                                         const std::vector<const double*>& blocks) {
  Marginals marginals(problem);
  if (blocks.size() > 1) marginals.ComputeSelectedInverse();
  std::vector<Eigen::MatrixXd> covariance;
  for (const double* block : blocks) covariance.push_back(marginals.Covariance(block));
  return covariance;
}

double MedianSeconds(const std::function<void()>& run) {
  std::array<double, kRuns> times;
  for (double& time : times) {
    const double start_s = ProcessorSeconds();
    run();
    time = ProcessorSeconds() - start_s;
  }
  std::nth_element(times.begin(), times.begin() + kRuns / 2, times.end());
  return times[kRuns / 2];
}

/// Prints a row of the table. Returns false if the covariances differ.
bool Compare(ceres::Problem& problem, const Wanted& wanted) {
  const std::vector<Eigen::MatrixXd> ours = ByMarginals(problem, wanted.blocks);
  const double ours_s = MedianSeconds([&] { ByMarginals(problem, wanted.blocks); });
  const CeresCovariance theirs = ComputeByCeres(problem, wanted.blocks, kCeresLimit_s);
  std::printf("| %s | %s | ", wanted.problem.c_str(), wanted.blocks_name.c_str());
  if (!theirs.error.empty()) {
    std::printf("%s | %.3g s | | |\n", theirs.error.c_str(), ours_s);
    return true;
  }
  const double difference = LargestDifference(theirs.covariance, ours);
  std::printf("%.3g s | %.3g s | %.3g | %.0e |\n", theirs.time_s, ours_s, theirs.time_s / ours_s,
              difference);
  std::fflush(stdout);
  return difference < kSameCovariance;
}

/// A bundle adjustment like the BAL problems. The cameras stand in a row, and each point is seen by
/// the cameras next to it. The first camera defines position and attitude, the second the scale.
class BundleAdjustment {
 public:
  BundleAdjustment(int cameras, int points) {
    std::mt19937 rng(8);
    std::normal_distribution<double> normal;
    for (int c = 0; c < cameras; ++c) {
      cameras_.push_back({0.05 * normal(rng), 0.05 * normal(rng), 0.05 * normal(rng), -1.0 * c,
                          0.3 * normal(rng), -10.0 + 0.3 * normal(rng), 800.0, -1e-2, 1e-3});
    }
    points_.reserve(static_cast<std::size_t>(points));
    for (int k = 0; k < points; ++k) {
      points_.emplace_back(cameras * static_cast<double>(k) / points, 3.0 * normal(rng),
                           1.5 * normal(rng));
      const int nearest = std::min(cameras - 1, static_cast<int>(points_.back().x()));
      for (int c = std::max(0, nearest - kSeenBefore); c < std::min(cameras, nearest + kSeenBefore);
           ++c) {
        AddObservation(cameras_[static_cast<std::size_t>(c)].data(), points_.back().data());
      }
    }
    problem_.SetManifold(cameras_[0].data(), new ceres::SubsetManifold(9, {0, 1, 2, 3, 4, 5}));
    problem_.SetManifold(cameras_[1].data(), new ceres::SubsetManifold(9, {3}));
  }

  ceres::Problem& problem() { return problem_; }

  std::vector<const double*> Cameras() const {
    std::vector<const double*> blocks;
    for (const auto& camera : cameras_) blocks.push_back(camera.data());
    return blocks;
  }
  std::vector<const double*> CamerasAndPoints() const {
    std::vector<const double*> blocks = Cameras();
    for (const Eigen::Vector3d& point : points_) blocks.push_back(point.data());
    return blocks;
  }

 private:
  static constexpr int kSeenBefore = 4;

  void AddObservation(double* camera, double* point) {
    double r[2];
    Reprojection{0.0, 0.0}(camera, point, r);
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Reprojection, 2, 9, 3>(new Reprojection{r[0], r[1]}),
        nullptr, camera, point);
  }

  std::vector<std::array<double, 9>> cameras_;
  std::vector<Eigen::Vector3d> points_;
  ceres::Problem problem_;
};

/// A pose graph like those of g2o files: poses on parallels of a sphere, each tied to the next one
/// and to the one below. The first pose is constant.
class SphereOfPoses {
 public:
  SphereOfPoses(int parallels, int poses_of_each)
      : p_(static_cast<std::size_t>(parallels * poses_of_each)), q_(p_.size()) {
    auto* quaternion = new ceres::EigenQuaternionManifold();
    for (std::size_t k = 0; k < p_.size(); ++k) {
      const double turn = 2.0 * M_PI * static_cast<double>(k) / poses_of_each;
      const double height = 1.8 * static_cast<double>(k) / static_cast<double>(p_.size()) - 0.9;
      const double radius = 50.0 * std::sqrt(1.0 - height * height);
      p_[k] = {radius * std::cos(turn), radius * std::sin(turn), 50.0 * height};
      q_[k] = Exp(Eigen::Vector3d(0.0, 0.0, turn)) * Exp(Eigen::Vector3d(0.0, height, 0.0));
      problem_.AddParameterBlock(p_[k].data(), 3);
      problem_.AddParameterBlock(q_[k].coeffs().data(), 4, quaternion);
    }
    problem_.SetParameterBlockConstant(p_[0].data());
    problem_.SetParameterBlockConstant(q_[0].coeffs().data());
    const auto ring = static_cast<std::size_t>(poses_of_each);
    for (std::size_t k = 1; k < p_.size(); ++k) {
      Tie(k - 1, k);
      if (k >= ring) Tie(k - ring, k);
    }
  }

  ceres::Problem& problem() { return problem_; }

  std::vector<const double*> Poses() const {
    std::vector<const double*> blocks;
    for (std::size_t k = 1; k < p_.size(); ++k) {
      blocks.push_back(p_[k].data());
      blocks.push_back(q_[k].coeffs().data());
    }
    return blocks;
  }

 private:
  void Tie(std::size_t a, std::size_t b) {
    Eigen::Matrix<double, 6, 1> sigma;
    sigma << 0.05, 0.05, 0.05, 0.01, 0.01, 0.01;
    auto* error =
        new RelativePoseError{q_[a].conjugate() * (p_[b] - p_[a]), q_[a].conjugate() * q_[b],
                              sigma.cwiseInverse().asDiagonal()};
    problem_.AddResidualBlock(
        new ceres::AutoDiffCostFunction<RelativePoseError, 6, 3, 4, 3, 4>(error), nullptr,
        p_[a].data(), q_[a].coeffs().data(), p_[b].data(), q_[b].coeffs().data());
  }

  std::vector<Eigen::Vector3d> p_;
  std::vector<Eigen::Quaterniond> q_;
  ceres::Problem problem_;
};

bool CompareBundleAdjustment(int cameras, int points) {
  BundleAdjustment adjustment(cameras, points);
  const std::string name = "bundle adjustment, " + std::to_string(cameras) + " cameras, " +
                           std::to_string(points) + " points";
  const bool same = Compare(adjustment.problem(), {name, "cameras", adjustment.Cameras()});
  return Compare(adjustment.problem(),
                 {name, "cameras and points", adjustment.CamerasAndPoints()}) &&
         same;
}

bool ComparePoseGraph(int parallels) {
  constexpr int kPosesOfEach = 50;
  SphereOfPoses graph(parallels, kPosesOfEach);
  return Compare(graph.problem(),
                 {"pose graph, " + std::to_string(parallels * kPosesOfEach) + " poses", "poses",
                  graph.Poses()});
}

bool CompareFlight(const std::string& size) {
  const auto flight = MakeFlightAtTruth(size, kNodeRate_hz);
  FlightNetwork& network = *flight->network;
  NetworkProblem problem(network.net());
  const auto address = [&](BlockId b) -> const double* {
    return network.net().block(b).value.get();
  };
  std::vector<const double*> nodes;
  for (const NodeBlocks& node : network.nodes()) {
    nodes.insert(nodes.end(), {address(node.q_mb.id), address(node.p_mb.id), address(node.v_m.id)});
  }
  const std::string name = "flight, " + size;
  const bool same = Compare(problem.problem(),
                            {name, "boresight", {address(network.calibration().boresight().id)}});
  return Compare(problem.problem(), {name, "states of all nodes", nodes}) && same;
}

int Main() {
  std::printf(
      "| problem | wanted | `ceres::Covariance` | `dn::Marginals` | ratio | difference |\n");
  std::printf("|---|---|--:|--:|--:|--:|\n");
  bool same = true;
  for (const auto& [cameras, points] : {std::pair{10, 500}, {30, 2000}}) {
    same = CompareBundleAdjustment(cameras, points) && same;
  }
  for (const int parallels : {2, 8, 20}) same = ComparePoseGraph(parallels) && same;
  same = CompareFlight("5min") && same;
  if (!same) std::fprintf(stderr, "covariances differ by more than %g\n", kSameCovariance);
  return same ? 0 : 1;
}

}  // namespace
}  // namespace dn::bench

int main() { return dn::bench::Main(); }
