#include <dn/error.h>
#include <dn/parallel.h>
#include <dn/stopwatch.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <string>
#include <utility>

#include "marginals_impl.h"
#include "rank.h"
#include "sparse/sparse.h"

namespace dn {
namespace {

/// If the probed information is below this value, the weak directions are examined.
constexpr double kProbeThreshold = 1e-12;

/// Number of values in cached columns above which the cache is cleared (256 MB).
constexpr std::size_t kCacheLimit = std::size_t{1} << 25;

/// Number of residual vectors that are projected together.
constexpr std::size_t kProjectedTogether = 16;

}  // namespace

void MarginalsOptions::Validate() const {
  if (threads < 1) {
    throw InvalidConfig("marginals: option threads is " + std::to_string(threads) +
                        ", must be at least 1");
  }
  if (!(null_tolerance > 0.0 && null_tolerance < 1.0)) {
    throw InvalidConfig("marginals: option null_tolerance is " + std::to_string(null_tolerance) +
                        ", must be in (0, 1)");
  }
}

Marginals::Impl::Impl(LinearizedNetwork snapshot, const MarginalsOptions& options)
    : linearized(std::move(snapshot)), threads(options.threads) {
  if (layout().size() > 0) Factor(options);
}

void Marginals::Impl::Factor(const MarginalsOptions& options) {
  const Linearization& linearization = network().linearization;
  const std::shared_ptr<SharedAnalysis> shared =
      options.analysis ? options.analysis : std::make_shared<SharedAnalysis>();
  Stopwatch watch;
  shared->impl().Assemble(layout(), linearization);
  sparse::SymmetricCsc& N = shared->impl().equations->N;
  scale = sparse::JacobiScale(N);
  sparse::ApplyScale(scale, &N);
  cholesky = std::make_unique<sparse::Cholesky>(*shared->impl().cholesky);
  timings.analyze_s = shared->impl().analyze_s;
  timings.assemble_s = watch.Restart() - timings.analyze_s;

  const bool definite = cholesky->Factorize(N);
  timings.factor_s = watch.Restart();

  if (!definite || ProbeInformation(linearization, scale, *cholesky) < kProbeThreshold) {
    ExamineRank(N, definite, options.null_tolerance);
  }
  timings.rank_s = watch.seconds();
}

void Marginals::Impl::ExamineRank(const sparse::SymmetricCsc& scaled_N, bool definite,
                                  double tolerance) {
  const ScaledDirections weak =
      FindFreeDirections(network().linearization, scale, scaled_N, *cholesky);
  const Eigen::Index free = (weak.information.array() < tolerance).count();
  if (free > 0) {
    throw RankDeficient("marginals: " + DescribeFreeDirections(network(), weak.v.leftCols(free)));
  }
  if (!definite || !cholesky->Factorize(scaled_N)) {
    throw RankDeficient("marginals: the normal matrix cannot be factored in double precision; " +
                        DescribeFreeDirections(network(), weak.v.leftCols(1)));
  }
}

int Marginals::Impl::Position(BlockId b) const {
  const BlockInfo& info = block(b);
  if (info.kind.stored_size == 0) {
    throw InvalidInput("marginals: block " + std::to_string(b) + " was removed");
  }
  const int position = layout().block_position[static_cast<std::size_t>(b)];
  if (position < 0 && !info.held) {
    throw RankDeficient("marginals: no active factor depends on block '" + info.name +
                        "', so it has no covariance; give it a prior or set it constant");
  }
  return position;
}

Eigen::MatrixXd Marginals::Impl::Solve(const std::vector<BlockId>& ids) const {
  int columns = 0;
  for (const BlockId b : ids) columns += block(b).kind.tangent_size;
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(layout().size(), columns);
  int column = 0;
  for (const BlockId b : ids) {
    if (const int position = Position(b); position >= 0) {
      for (int k = 0; k < block(b).kind.tangent_size; ++k) {
        const int i = Offset(position) + k;
        B(i, column + k) = scale[i];
      }
    }
    column += block(b).kind.tangent_size;
  }
  return SolveScaled(std::move(B));
}

Eigen::MatrixXd Marginals::Impl::Solve(const BlockColumns& rhs) const {
  const Eigen::Index columns = rhs.empty() ? 0 : rhs.begin()->second.cols();
  Eigen::MatrixXd B = Eigen::MatrixXd::Zero(layout().size(), columns);
  for (const auto& [b, rows] : rhs) {
    const int position = Position(b);
    if (position < 0 || rows.rows() != block(b).kind.tangent_size || rows.cols() != columns) {
      throw InvalidInput("marginals: right-hand side of block '" + block(b).name + "' is " +
                         std::to_string(rows.rows()) + " x " + std::to_string(rows.cols()) +
                         (position < 0 ? ", but the block is constant" : ", which does not fit"));
    }
    B.middleRows(Offset(position), rows.rows()) =
        scale.segment(Offset(position), rows.rows()).asDiagonal() * rows;
  }
  return SolveScaled(std::move(B));
}

Eigen::MatrixXd Marginals::Impl::SolveScaled(Eigen::MatrixXd B) const {
  if (B.size() == 0) return B;
  B = cholesky->Solve(B, threads);
  B.array().colwise() *= scale.array();
  return B;
}

void Marginals::Impl::Project(Eigen::Ref<Eigen::MatrixXd> E) const {
  const Linearization& linearization = network().linearization;
  // Calls use(column of the unknown in W, its Jacobian column, its scale) for each unknown of an
  // edge.
  const auto for_unknowns = [&](const Linearization::Edge& edge, const auto& use) {
    const auto J = linearization.jacobian(edge);
    int column = 0;
    for (int b = 0; b < edge.num_blocks; ++b) {
      const int position = linearization.positions(edge)[b];
      for (int i = 0; i < layout().block_size(position); ++i) {
        const int unknown = Offset(position) + i;
        use(cholesky->permuted_index()[AsSize(unknown)], J.col(column++), scale[unknown]);
      }
    }
  };
  Eigen::MatrixXd W = Eigen::MatrixXd::Zero(E.rows(), layout().size());
  for (const Linearization::Edge& edge : linearization.edges()) {
    for_unknowns(edge, [&](int at, const auto& J, double scale_of) {
      for (int r = 0; r < edge.rows; ++r) {
        if (J[r] != 0.0) W.col(at) += scale_of * J[r] * E.col(edge.first_row + r);
      }
    });
  }
  cholesky->SolveInPlace(W);
  for (const Linearization::Edge& edge : linearization.edges()) {
    for_unknowns(edge, [&](int at, const auto& J, double scale_of) {
      for (int r = 0; r < edge.rows; ++r) {
        if (J[r] != 0.0) E.col(edge.first_row + r) -= scale_of * J[r] * W.col(at);
      }
    });
  }
}

const Eigen::MatrixXd& Marginals::Impl::CachedColumns(BlockId b) {
  if (const auto it = cache.find(b); it != cache.end()) return it->second;
  Eigen::MatrixXd columns = Solve({b});
  cached += static_cast<std::size_t>(columns.size());
  if (cached > kCacheLimit) {
    cache.clear();
    cached = static_cast<std::size_t>(columns.size());
  }
  return cache.emplace(b, std::move(columns)).first->second;
}

Eigen::MatrixXd Marginals::Impl::Rows(const Eigen::MatrixXd& columns, BlockId b) const {
  const int position = Position(b);
  if (position < 0) return Eigen::MatrixXd::Zero(block(b).kind.tangent_size, columns.cols());
  return columns.middleRows(Offset(position), block(b).kind.tangent_size);
}

std::optional<Eigen::MatrixXd> Marginals::Impl::Selected(BlockId a, BlockId b) const {
  const int pa = Position(a), pb = Position(b);
  Eigen::MatrixXd Z = Eigen::MatrixXd::Zero(block(a).kind.tangent_size, block(b).kind.tangent_size);
  if (pa < 0 || pb < 0) return Z;
  const std::vector<int>& order = cholesky->permuted_index();
  for (int c = 0; c < Z.cols(); ++c) {
    for (int r = 0; r < Z.rows(); ++r) {
      const int i = Offset(pa) + r, j = Offset(pb) + c;
      const std::optional<double> entry =
          selected->At(order[static_cast<std::size_t>(i)], order[static_cast<std::size_t>(j)]);
      if (!entry) return std::nullopt;
      Z(r, c) = *entry * scale[i] * scale[j];
    }
  }
  return Z;
}

std::optional<Eigen::MatrixXd> Marginals::Impl::Selected(std::span<const BlockId> blocks) const {
  std::vector<int> indices;        // of the unknowns, in the order of L
  std::vector<Eigen::Index> rows;  // position of each of these unknowns in the result
  std::vector<double> scales;
  Eigen::Index size = 0;
  for (const BlockId b : blocks) {
    const int position = Position(b);
    const int tangent = block(b).kind.tangent_size;
    for (int k = 0; position >= 0 && k < tangent; ++k) {
      const int unknown = Offset(position) + k;
      indices.push_back(cholesky->permuted_index()[AsSize(unknown)]);
      rows.push_back(size + k);
      scales.push_back(scale[unknown]);
    }
    size += tangent;
  }
  if (indices.empty()) return Eigen::MatrixXd::Zero(size, size);
  Eigen::MatrixXd Z;
  if (!selected->Gather(indices, &Z)) return std::nullopt;
  const Eigen::Map<const Eigen::VectorXd> s(scales.data(),
                                            static_cast<Eigen::Index>(scales.size()));
  Z = (s.asDiagonal() * Z * s.asDiagonal()).eval();
  if (Z.rows() == size) return Z;
  Eigen::MatrixXd with_constant = Eigen::MatrixXd::Zero(size, size);
  with_constant(rows, rows) = Z;
  return with_constant;
}

void Marginals::Impl::RequireSelected() const {
  if (!selected && layout().size() > 0) {
    throw InvalidInput("marginals: call ComputeSelectedInverse first");
  }
}

Eigen::MatrixXd Marginals::Columns::Rows(BlockId b) const { return impl_->Rows(columns_, b); }

Marginals::Marginals(const Network& network, const MarginalsOptions& options) {
  options.Validate();
  const Stopwatch watch;
  LinearizedNetwork linearized(network, options.threads);
  const double evaluate_s = watch.seconds();
  const sparse::SerialBlas serial;
  impl_ = std::make_shared<Impl>(std::move(linearized), options);
  impl_->timings.assemble_s += evaluate_s;
}

Marginals::Marginals(const LinearizedNetwork& linearized, const MarginalsOptions& options) {
  options.Validate();
  const sparse::SerialBlas serial;
  impl_ = std::make_shared<Impl>(linearized, options);
}

Marginals::~Marginals() = default;
Marginals::Marginals(Marginals&&) noexcept = default;
Marginals& Marginals::operator=(Marginals&&) noexcept = default;

Eigen::MatrixXd Marginals::Covariance(BlockId a) const {
  if (impl_->selected) return *impl_->Selected(a, a);
  const Eigen::MatrixXd C = impl_->Rows(impl_->CachedColumns(a), a);
  return 0.5 * (C + C.transpose());
}

Eigen::MatrixXd Marginals::Covariance(BlockId a, BlockId b) const {
  if (a == b) return Covariance(a);
  if (impl_->selected) {
    if (const std::optional<Eigen::MatrixXd> Z = impl_->Selected(a, b)) return *Z;
  }
  const bool a_is_cheaper = impl_->cache.contains(a) ||
                            (!impl_->cache.contains(b) && impl_->block(a).kind.tangent_size <=
                                                              impl_->block(b).kind.tangent_size);
  if (a_is_cheaper) return impl_->Rows(impl_->CachedColumns(a), b).transpose();
  return impl_->Rows(impl_->CachedColumns(b), a);
}

Marginals::Columns Marginals::SolveColumns(const std::vector<BlockId>& blocks) const {
  Columns columns;
  columns.impl_ = impl_;
  columns.columns_ = impl_->Solve(blocks);
  return columns;
}

Marginals::Columns Marginals::Solve(const BlockColumns& rhs) const {
  Columns columns;
  columns.impl_ = impl_;
  columns.columns_ = impl_->Solve(rhs);
  return columns;
}

Eigen::MatrixXd Marginals::Solve(const Eigen::MatrixXd& rhs) const {
  if (rhs.rows() != num_parameters()) {
    throw InvalidInput("marginals: right-hand sides of " + std::to_string(rhs.rows()) +
                       " rows for " + std::to_string(num_parameters()) + " unknowns");
  }
  return impl_->SolveScaled(impl_->scale.asDiagonal() * rhs);
}

void Marginals::ComputeSelectedInverse() {
  if (impl_->selected || impl_->layout().size() == 0) return;
  const Stopwatch watch;
  const sparse::SerialBlas serial;
  impl_->selected = std::make_unique<sparse::SelectedInverse>(*impl_->cholesky, impl_->threads);
  impl_->timings.selected_inverse_s = watch.seconds();
}

Eigen::MatrixXd Marginals::DiagonalBlock(BlockId a) const {
  impl_->RequireSelected();
  return *impl_->Selected(a, a);
}

std::optional<Eigen::MatrixXd> Marginals::JointSelectedCovariance(
    std::span<const BlockId> blocks) const {
  impl_->RequireSelected();
  return impl_->Selected(blocks);
}

std::optional<Eigen::MatrixXd> Marginals::SelectedCovariance(BlockId a, BlockId b) const {
  impl_->RequireSelected();
  return impl_->Selected(a, b);
}

Eigen::MatrixXd Marginals::ReducedNormal(BlockId a) const {
  if (impl_->Position(a) < 0) {
    throw InvalidInput("marginals: block '" + impl_->block(a).name +
                       "' is constant, so it has no reduced normal matrix");
  }
  const Eigen::MatrixXd C = Covariance(a);
  return C.llt().solve(Eigen::MatrixXd::Identity(C.rows(), C.cols()));
}

Eigen::MatrixXd Marginals::Project(const Eigen::MatrixXd& E) const {
  Eigen::MatrixXd by_row = E.transpose();
  ProjectRows(&by_row);
  return by_row.transpose();
}

void Marginals::ProjectRows(Eigen::MatrixXd* E) const {
  if (E->cols() != linearized().rows()) {
    throw InvalidInput("marginals: vectors of " + std::to_string(E->cols()) + " residuals for " +
                       std::to_string(linearized().rows()));
  }
  if (num_parameters() == 0) return;
  ParallelForChunks(AsSize(E->rows()), kProjectedTogether, impl_->threads,
                    [&](std::size_t, std::size_t first, std::size_t past) {
                      const sparse::SerialBlas serial;
                      impl_->Project(E->middleRows(static_cast<Eigen::Index>(first),
                                                   static_cast<Eigen::Index>(past - first)));
                    });
}

const LinearizedNetwork& Marginals::linearized() const { return impl_->linearized; }
int Marginals::threads() const { return impl_->threads; }

int Marginals::num_parameters() const { return impl_->layout().size(); }

double Marginals::LogDeterminant() const {
  if (!impl_->cholesky) return 0.0;
  return impl_->cholesky->LogDeterminant() - 2.0 * impl_->scale.array().log().sum();
}

long Marginals::factor_nonzeros() const {
  return impl_->cholesky ? impl_->cholesky->num_nonzeros() : 0;
}

const Marginals::Timings& Marginals::timings() const { return impl_->timings; }

}  // namespace dn
