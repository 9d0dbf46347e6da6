#include <dn/adjustment/stages.h>
#include <dn/navigation/robust_scale.h>
#include <dn/parallel.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

namespace dn {
namespace {

constexpr double kCauchyNorm = 3.0;
constexpr int kMaxSteps = 30;
// A hundredth of the best sigma of an angle; the network refines the start.
constexpr double kStepRad = 1e-7;

/// The residual of a pair as a linear function of a small rotation of a boresight.
struct PairAtBoresight {
  Eigen::Vector3d r;
  Eigen::Matrix3d A;
};

/// Returns nullopt if the factor is not defined there, or if it is user-defined with another size.
std::optional<PairAtBoresight> AtBoresight(const FlightNetwork& network, FactorId id,
                                           BlockId boresight) {
  Eigen::VectorXd r;
  std::vector<Eigen::MatrixXd> J;
  const FactorRecord& record = network.net().factor(id);
  const auto at = std::find(record.blocks.begin(), record.blocks.end(), boresight);
  if (record.factor->residual_size() != 3 || at == record.blocks.end()) return std::nullopt;
  if (!network.net().EvaluateFactor(id, &r, &J)) return std::nullopt;
  return PairAtBoresight{r, J[static_cast<std::size_t>(at - record.blocks.begin())]};
}

/// Returns whether the pair starts the boresight of scanner k: its own pairs do, and those with
/// scanners before it, which have started.
bool Starts(const LidarPair& pair, std::size_t k) {
  return std::max(pair.scanner_i, pair.scanner_j) == static_cast<int>(k);
}

class PairsAtBoresight {
 public:
  PairsAtBoresight(const FlightNetwork& network, std::size_t scanner, int threads) {
    const BlockId boresight = network.calibration().scanners()[scanner].boresight.id;
    std::vector<std::optional<PairAtBoresight>> of_edge(network.pairs().edges().size());
    ParallelFor(static_cast<int>(of_edge.size()), threads, [&](int at) {
      const auto k = static_cast<std::size_t>(at);
      const PairEdge& edge = network.pairs().edges()[k];
      if (Starts(edge.pair, scanner)) of_edge[k] = AtBoresight(network, edge.id, boresight);
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
  for (std::size_t k = 0; k < network.calibration().scanners().size(); ++k) {
    const Block<LeftRotation> boresight = network.calibration().scanners()[k].boresight;
    for (int step = 0; step < kMaxSteps && !net.block(boresight.id).held; ++step) {
      const Eigen::Vector3d d = PairsAtBoresight(network, k, run.options().threads).Turn();
      net.SetValue(boresight, Exp(d) * net.Value(boresight));
      if (d.norm() < kStepRad) break;
    }
  }
}

}  // namespace dn
