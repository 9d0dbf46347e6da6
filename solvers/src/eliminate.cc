#include <dn/error.h>
#include <dn/linear_prior.h>
#include <dn/solvers/eliminate.h>
#include <dn/solvers/linearized_network.h>
#include <dn/solvers/marginals.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <utility>

namespace dn {
namespace {

/// Rows that are compressed together by one QR decomposition.
constexpr Eigen::Index kRowsAtOnce = 2048;
/// Directions of the scaled neighbours that keep less than this part of their Jacobian carry no
/// information: the elimination leaves only rounding errors of them.
constexpr double kRankTolerance = 1e-10;

/// Returns the triangular factor of A, columns x columns.
Eigen::MatrixXd UpperTriangle(const Eigen::MatrixXd& A) {
  const Eigen::Index n = A.cols();
  Eigen::MatrixXd R = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index first = 0; first < A.rows(); first += kRowsAtOnce) {
    const Eigen::Index rows = std::min(kRowsAtOnce, A.rows() - first);
    Eigen::MatrixXd stack(n + rows, n);
    stack << R, A.middleRows(first, rows);
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(stack);
    R = qr.matrixQR().topRows(n).triangularView<Eigen::Upper>();
  }
  return R;
}

/// The factors on the blocks to eliminate as a network of their own.
class Part {
 public:
  Part(const Network& whole, const std::vector<BlockId>& blocks) : whole_(whole) {
    const std::set<BlockId> eliminated(blocks.begin(), blocks.end());
    for (const BlockId b : eliminated) AddBlock(b);
    num_eliminated_ = net_.num_blocks();
    for (FactorId id = 0; id < whole.num_factors(); ++id) {
      const FactorRecord& record = whole.factor(id);
      if (!record.active || !Touches(record, eliminated)) continue;
      std::vector<BlockId> here;
      for (const BlockId b : record.blocks) here.push_back(AddBlock(b));
      const FactorId added = net_.AddFactor(record.factor, here);
      net_.SetLoss(added, record.loss);
      net_.Tag(added, whole.group(id), record.t_s);
    }
  }

  int num_factors() const { return net_.num_factors(); }
  bool IsNeighbour(BlockId here) const { return here >= num_eliminated_ && !net_.block(here).held; }
  const Network& network() const { return net_; }
  BlockId InWhole(BlockId here) const { return in_whole_[static_cast<std::size_t>(here)]; }

  /// Returns the same network with the neighbours constant.
  Network WithConstantNeighbours() const {
    Network net = net_;
    for (BlockId b = num_eliminated_; b < net.num_blocks(); ++b) net.Hold(b);
    return net;
  }

 private:
  static bool Touches(const FactorRecord& record, const std::set<BlockId>& blocks) {
    return std::any_of(record.blocks.begin(), record.blocks.end(),
                       [&](BlockId b) { return blocks.contains(b); });
  }

  BlockId AddBlock(BlockId b) {
    const BlockRecord& record = whole_.block(b);
    if (const auto known = in_part_.find(b); known != in_part_.end()) return known->second;
    const BlockId here = net_.AddBlock(record.name, record.kind, whole_.Value(b), record.owner);
    net_.Hold(here, record.held);
    net_.SetLabel(here, record.label);
    in_whole_.push_back(b);
    in_part_.emplace(b, here);
    return here;
  }

  const Network& whole_;
  Network net_;
  int num_eliminated_ = 0;
  std::vector<BlockId> in_whole_;
  std::map<BlockId, BlockId> in_part_;
};

/// The factors of a part as linear functions of the neighbours s: residual = A s + b. The
/// eliminated blocks e then have their best values e = -(X s + x).
struct Reduced {
  std::vector<BlockId> neighbours;  // in the part
  std::vector<BlockId> eliminated;
  Eigen::MatrixXd A;
  Eigen::VectorXd b;
  Eigen::MatrixXd X;
  Eigen::VectorXd scale;  // norms of the Jacobian columns of s before the elimination
};

Reduced Reduce(const Part& part, int threads) {
  const LinearizedNetwork all(part.network(), threads);
  const Network only_eliminated = part.WithConstantNeighbours();
  const Marginals inner(only_eliminated, {.threads = threads});
  Reduced reduced;
  reduced.eliminated = inner.linearized().unknowns();
  for (const BlockId b : all.unknowns()) {
    if (part.IsNeighbour(b)) reduced.neighbours.push_back(b);
  }
  Eigen::Index columns = 0;
  for (const BlockId b : reduced.neighbours) columns += part.network().block(b).kind.tangent_size;
  Eigen::MatrixXd choose = Eigen::MatrixXd::Zero(all.parameters(), columns);
  Eigen::Index column = 0;
  for (const BlockId b : reduced.neighbours) {
    const int size = part.network().block(b).kind.tangent_size;
    choose.block(all.FirstColumn(b), column, size, size).setIdentity();
    column += size;
  }
  Eigen::MatrixXd with_residual(all.rows(), columns + 1);
  with_residual << all.Times(choose), all.residual();
  const Eigen::VectorXd scale = with_residual.leftCols(columns).colwise().norm();
  const Eigen::MatrixXd X = inner.Solve(inner.linearized().TransposeTimes(with_residual));
  with_residual -= inner.linearized().Times(X);
  reduced.A = with_residual.leftCols(columns);
  reduced.b = with_residual.col(columns);
  reduced.X = X.leftCols(columns);
  reduced.scale = scale;
  return reduced;
}

/// R and d of a prior, with the rows that carry information; the last number of the triangle is the
/// residual that remains.
struct Compressed {
  Eigen::MatrixXd R;
  Eigen::VectorXd d;
  double rest = 0.0;
};

Compressed Compress(const Reduced& reduced) {
  const Eigen::Index n = reduced.A.cols();
  Eigen::MatrixXd both(reduced.A.rows(), n + 1);
  both << reduced.A, reduced.b;
  const Eigen::MatrixXd triangle = UpperTriangle(both);
  Compressed compressed;
  compressed.rest = std::abs(triangle(n, n));
  if (n == 0) return compressed;
  const Eigen::MatrixXd R = triangle.topLeftCorner(n, n);
  const Eigen::VectorXd scale = reduced.scale.cwiseMax(std::numeric_limits<double>::min());
  const Eigen::MatrixXd scaled = R * scale.cwiseInverse().asDiagonal();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(scaled);
  const Eigen::Index rank = (qr.matrixR().diagonal().cwiseAbs().array() > kRankTolerance).count();
  const Eigen::MatrixXd Q = qr.householderQ();
  const Eigen::VectorXd d = Q.transpose() * triangle.col(n).head(n);
  compressed.R = (Q.transpose() * R).topRows(rank);
  compressed.d = d.head(rank);
  compressed.rest = std::hypot(compressed.rest, d.tail(n - rank).norm());
  return compressed;
}

/// Moves blocks of a network by tangent steps that stand one after the other in `step`.
void MoveBlocks(const std::vector<BlockId>& blocks, const Eigen::VectorXd& step, Network* network) {
  Eigen::Index at = 0;
  for (const BlockId b : blocks) {
    const BlockKind& kind = network->block(b).kind;
    Eigen::VectorXd moved(kind.stored_size);
    Plus(kind, network->block(b).value.get(), step.data() + at, moved.data());
    network->SetRaw(b, moved.data());
    at += kind.tangent_size;
  }
}

/// Returns the largest change of the residuals that a linear function does not explain, as a norm.
/// The neighbours move by one sigma of the prior in any direction. The change grows with the square
/// of the movement. Infinite if a factor is undefined there.
double Nonlinearity(const Part& part, const Reduced& reduced, const Compressed& prior,
                    int threads) {
  const LinearizedNetwork start(part.network(), threads);
  const Eigen::MatrixXd steps =
      prior.R.completeOrthogonalDecomposition().pseudoInverse();  // one column per direction
  double largest = 0.0;
  for (Eigen::Index k = 0; k < steps.cols(); ++k) {
    Network moved = part.network();
    MoveBlocks(reduced.neighbours, steps.col(k), &moved);
    MoveBlocks(reduced.eliminated, -reduced.X * steps.col(k), &moved);
    Eigen::VectorXd change = -start.residual() - reduced.A * steps.col(k);
    for (const LinearizedNetwork::FactorRows& rows : start.factors()) {
      Eigen::VectorXd r;
      if (!moved.EvaluateFactor(rows.factor, &r) || !r.allFinite()) {
        return std::numeric_limits<double>::infinity();
      }
      change.segment(rows.first, rows.count) += std::sqrt(rows.weight) * r;
    }
    largest = std::max(largest, change.norm());
  }
  return largest;
}

}  // namespace

Elimination Eliminate(Network* network, const std::vector<BlockId>& blocks,
                      const EliminateOptions& options) {
  const Part part(*network, blocks);
  Elimination elimination;
  elimination.factors = part.num_factors();
  std::shared_ptr<const LinearPrior> prior;
  if (part.num_factors() > 0) {
    const Reduced reduced = Reduce(part, options.threads);
    const Compressed compressed = Compress(reduced);
    elimination.cost = 0.5 * compressed.rest * compressed.rest;
    if (compressed.R.rows() > 0) {
      std::vector<BlockKind> kinds;
      std::vector<double> center;
      for (const BlockId b : reduced.neighbours) {
        const BlockRecord& record = part.network().block(b);
        elimination.neighbours.push_back(part.InWhole(b));
        kinds.push_back(record.kind);
        center.insert(center.end(), record.value.get(),
                      record.value.get() + record.kind.stored_size);
      }
      prior = std::make_shared<const LinearPrior>(
          std::move(kinds),
          Eigen::Map<const Eigen::VectorXd>(center.data(),
                                            static_cast<Eigen::Index>(center.size())),
          compressed.R, compressed.d, Nonlinearity(part, reduced, compressed, options.threads));
    }
  }
  network->RemoveBlocks(blocks);
  if (prior == nullptr) return elimination;
  elimination.prior = network->AddFactor(prior, elimination.neighbours);
  network->Tag(elimination.prior, FactorGroup{options.name, {}, "", FactorGroup::Kind::kPrior},
               std::numeric_limits<double>::quiet_NaN());
  return elimination;
}

std::vector<MovedPrior> FindMovedPriors(const Network& network, double error) {
  std::vector<MovedPrior> moved;
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    const FactorRecord& record = network.factor(id);
    if (!record.active) continue;
    const auto* prior = dynamic_cast<const LinearPrior*>(record.factor.get());
    if (prior == nullptr || prior->nonlinearity() == 0.0) continue;
    std::vector<const double*> x;
    for (const BlockId b : record.blocks) x.push_back(network.block(b).value.get());
    const double sigmas = (prior->sqrt_information() * prior->Movement(x.data())).norm();
    const double estimated = sigmas == 0.0 ? 0.0 : prior->nonlinearity() * sigmas * sigmas;
    if (estimated <= error) continue;
    char text[160];
    std::snprintf(text, sizeof(text),
                  " has moved by %.2g sigmas since the elimination; its linearisation is wrong by "
                  "about %.2g sigmas",
                  sigmas, estimated);
    moved.push_back({id, sigmas, estimated, network.DescribeFactor(id) + text});
  }
  return moved;
}

}  // namespace dn
