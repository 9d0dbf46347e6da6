#include <dn/calibration/stages.h>
#include <dn/navigation/robust_scale.h>

#include <Eigen/Cholesky>

namespace dn {
namespace {

constexpr std::size_t kBoresightBlock = 6;  // of a pair
constexpr double kCauchyNorm = 3.0;
constexpr int kMaxSteps = 30;
constexpr double kStepRad = 1e-8;

// One step of Gauss-Newton with Cauchy weights.
Eigen::Vector3d Step(const FlightNetwork& network) {
  std::vector<Eigen::Vector3d> r;
  std::vector<Eigen::Matrix3d> A;
  std::vector<double> norm2;
  for (const auto& edge : network.pair_edges) {
    Eigen::VectorXd residual;
    std::vector<Eigen::MatrixXd> J;
    network.net.EvaluateFactor(edge.id, &residual, &J);
    r.emplace_back(residual);
    A.emplace_back(J[kBoresightBlock]);
    norm2.push_back(residual.squaredNorm());
  }
  const double scale2 = RobustVariance(norm2);
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < r.size(); ++k) {
    const double weight = 1.0 / (1.0 + norm2[k] / (kCauchyNorm * kCauchyNorm * scale2));
    N += weight * A[k].transpose() * A[k];
    b += weight * A[k].transpose() * r[k];
  }
  // Weak directions are left to the full network: a small ridge, 1 deg per sqrt(number of pairs).
  N.diagonal().array() += 1.0 / (kRadPerDeg * kRadPerDeg);
  return -N.ldlt().solve(b);
}

}  // namespace

void StartBoresight(AdjustmentRun& run) {
  FlightNetwork& network = run.network();
  Network& net = network.net;
  if (net.block(network.boresight.id).held) return;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector3d d = Step(network);
    net.SetValue(network.boresight, Exp(d) * net.Value(network.boresight));
    if (d.norm() < kStepRad) break;
  }
}

}  // namespace dn
