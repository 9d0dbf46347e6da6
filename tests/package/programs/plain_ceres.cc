// A program that uses Ceres alone, except for the covariances of its problem.
#include <ceres/autodiff_cost_function.h>
#include <ceres/covariance.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/rotation.h>
#include <ceres/solver.h>
#include <dn/solvers/marginals.h>

#include <array>
#include <random>
#include <utility>
#include <vector>

#include "check.h"

namespace {

/// A point seen from a rotated and shifted station.
struct Seen {
  std::array<double, 3> measured;
  template <class T>
  bool operator()(const T* q, const T* p, const T* point, T* r) const {
    const T d[3] = {point[0] - p[0], point[1] - p[1], point[2] - p[2]};
    ceres::QuaternionRotatePoint(q, d, r);
    for (std::size_t i = 0; i < 3; ++i) r[i] = (r[i] - measured[i]) / 0.01;
    return true;
  }
};

}  // namespace

int main() {
  std::mt19937 rng(4);
  std::normal_distribution<double> normal;
  std::vector<std::array<double, 3>> points(20), positions(4);
  std::vector<std::array<double, 4>> rotations(4, {1.0, 0.0, 0.0, 0.0});
  for (auto& point : points) {
    for (double& x : point) x = 10.0 * normal(rng);
  }
  ceres::Problem problem;
  for (std::size_t s = 0; s < positions.size(); ++s) {
    for (double& x : positions[s]) x = normal(rng);
    for (double& x : rotations[s]) x += 0.1 * normal(rng);
    for (auto& point : points) {
      Seen seen{};
      std::array<double, 3> r;
      seen(rotations[s].data(), positions[s].data(), point.data(), r.data());
      for (std::size_t i = 0; i < 3; ++i) seen.measured[i] = 0.01 * (r[i] + normal(rng));
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<Seen, 3, 4, 3, 3>(new Seen(seen)),
                               nullptr, rotations[s].data(), positions[s].data(), point.data());
    }
    problem.SetManifold(rotations[s].data(), new ceres::QuaternionManifold());
  }
  problem.SetParameterBlockConstant(rotations[0].data());
  problem.SetParameterBlockConstant(positions[0].data());
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);

  const dn::Marginals marginals(problem);
  ceres::Covariance covariance{ceres::Covariance::Options()};
  bool good = summary.IsSolutionUsable();
  for (const double* block : {rotations[3].data(), positions[2].data(), points[7].data()}) {
    std::vector<std::pair<const double*, const double*>> wanted{{block, block}};
    Eigen::Matrix3d expected;
    good = covariance.Compute(wanted, &problem) &&
           covariance.GetCovarianceBlockInTangentSpace(block, block, expected.data()) && good;
    const double difference = (marginals.Covariance(block) - expected).norm() / expected.norm();
    good = Between("difference of the covariances", difference, 0.0, 1e-6) && good;
  }
  return good ? 0 : 1;
}
