#include <dn/calibration/stages.h>
#include <dn/navigation/robust_scale.h>
#include <dn/parallel.h>

#include <Eigen/Cholesky>
#include <cstddef>
#include <vector>

namespace dn {
namespace {

constexpr std::size_t kBoresightBlock = 6;  // of a pair
constexpr std::size_t kPairsPerTask = 512;
constexpr double kCauchyNorm = 3.0;
constexpr int kMaxSteps = 30;
// A hundredth of what an angle is known to at best: the network goes on from here.
constexpr double kStepRad = 1e-7;

/// The residuals of the pairs as linear functions of a small turn of the boresight.
struct PairsAtBoresight {
  std::vector<Eigen::Vector3d> r;
  std::vector<Eigen::Matrix3d> A;

  PairsAtBoresight(const FlightNetwork& network, int threads)
      : r(network.pair_edges.size()), A(network.pair_edges.size()) {
    ParallelForChunks(r.size(), kPairsPerTask, threads,
                      [&](std::size_t /*chunk*/, std::size_t first, std::size_t past) {
                        Eigen::VectorXd residual;
                        std::vector<Eigen::MatrixXd> J;
                        for (std::size_t k = first; k < past; ++k) {
                          network.net.EvaluateFactor(network.pair_edges[k].id, &residual, &J);
                          r[k] = residual;
                          A[k] = J[kBoresightBlock];
                        }
                      });
  }

  /// One step of Gauss-Newton with Cauchy weights, from a turn d.
  Eigen::Vector3d Step(const Eigen::Vector3d& d) const {
    std::vector<Eigen::Vector3d> at_d(r.size());
    std::vector<double> norm2(r.size());
    for (std::size_t k = 0; k < r.size(); ++k) {
      at_d[k] = r[k] + A[k] * d;
      norm2[k] = at_d[k].squaredNorm();
    }
    const double scale2 = RobustVariance(norm2);
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < r.size(); ++k) {
      const double weight = 1.0 / (1.0 + norm2[k] / (kCauchyNorm * kCauchyNorm * scale2));
      N += weight * A[k].transpose() * A[k];
      b += weight * A[k].transpose() * at_d[k];
    }
    // Weak directions are left to the full network: a small ridge, 1 deg per sqrt(number of pairs).
    N.diagonal().array() += 1.0 / (kRadPerDeg * kRadPerDeg);
    return -N.ldlt().solve(b);
  }

  /// The turn at which the steps end.
  Eigen::Vector3d Turn() const {
    Eigen::Vector3d d = Eigen::Vector3d::Zero();
    for (int step = 0; step < kMaxSteps; ++step) {
      const Eigen::Vector3d more = Step(d);
      d += more;
      if (more.norm() < kStepRad) break;
    }
    return d;
  }
};

}  // namespace

void StartBoresight(AdjustmentRun& run) {
  FlightNetwork& network = run.network();
  Network& net = network.net;
  if (net.block(network.boresight.id).held) return;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector3d d = PairsAtBoresight(network, run.options().threads).Turn();
    net.SetValue(network.boresight, Exp(d) * net.Value(network.boresight));
    if (d.norm() < kStepRad) break;
  }
}

}  // namespace dn
