#include <dn/adjustment/stages.h>
#include <dn/navigation/robust_scale.h>
#include <dn/parallel.h>

#include <Eigen/Cholesky>
#include <cstddef>
#include <optional>
#include <vector>

namespace dn {
namespace {

constexpr std::size_t kBoresightBlock = 6;  // index in the blocks of a pair factor
constexpr double kCauchyNorm = 3.0;
constexpr int kMaxSteps = 30;
// A hundredth of the best sigma of an angle; the network refines the start.
constexpr double kStepRad = 1e-7;

/// The residual of a pair as a linear function of a small rotation of the boresight.
struct PairAtBoresight {
  Eigen::Vector3d r;
  Eigen::Matrix3d A;
};

/// Returns nullopt if the factor is not defined there, or if it is user-defined with another size.
std::optional<PairAtBoresight> AtBoresight(const FlightNetwork& network, FactorId id) {
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  if (network.net().factor(id).factor->residual_size() != 3) return std::nullopt;
  if (!network.net().EvaluateFactor(id, &r, &J)) return std::nullopt;
  return PairAtBoresight{r, J[kBoresightBlock]};
}

class PairsAtBoresight {
 public:
  PairsAtBoresight(const FlightNetwork& network, int threads) {
    std::vector<std::optional<PairAtBoresight>> of_edge(network.pairs().edges().size());
    ParallelFor(static_cast<int>(of_edge.size()), threads, [&](int at) {
      const auto k = static_cast<std::size_t>(at);
      of_edge[k] = AtBoresight(network, network.pairs().edges()[k].id);
    });
    for (const std::optional<PairAtBoresight>& pair : of_edge) {
      if (pair) pairs_.push_back(*pair);
    }
  }

  /// Returns the rotation at which the steps converge.
  Eigen::Vector3d Turn() const {
    Eigen::Vector3d d = Eigen::Vector3d::Zero();
    for (int step = 0; step < kMaxSteps && !pairs_.empty(); ++step) {
      const Eigen::Vector3d more = Step(d);
      d += more;
      if (more.norm() < kStepRad) break;
    }
    return d;
  }

 private:
  /// Returns a Gauss-Newton step with Cauchy weights, from the rotation d.
  Eigen::Vector3d Step(const Eigen::Vector3d& d) const {
    std::vector<Eigen::Vector3d> r;
    std::vector<double> norm2;
    for (const PairAtBoresight& pair : pairs_) {
      r.emplace_back(pair.r + pair.A * d);
      norm2.push_back(r.back().squaredNorm());
    }
    const double scale2 = RobustVariance(norm2);
    Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (std::size_t k = 0; k < pairs_.size(); ++k) {
      const double weight = 1.0 / (1.0 + norm2[k] / (kCauchyNorm * kCauchyNorm * scale2));
      N += weight * pairs_[k].A.transpose() * pairs_[k].A;
      b += weight * pairs_[k].A.transpose() * r[k];
    }
    // A small ridge, 1 deg per sqrt(number of pairs), leaves weak directions to the full network.
    N.diagonal().array() += 1.0 / (kRadPerDeg * kRadPerDeg);
    return -N.ldlt().solve(b);
  }

  std::vector<PairAtBoresight> pairs_;
};

}  // namespace

void StartBoresight(AdjustmentRun& run) {
  FlightNetwork& network = run.network();
  Network& net = network.net();
  if (net.block(network.calibration().boresight().id).held) return;
  for (int step = 0; step < kMaxSteps; ++step) {
    const Eigen::Vector3d d = PairsAtBoresight(network, run.options().threads).Turn();
    net.SetValue(network.calibration().boresight(),
                 Exp(d) * net.Value(network.calibration().boresight()));
    if (d.norm() < kStepRad) break;
  }
}

}  // namespace dn
