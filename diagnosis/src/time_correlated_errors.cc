#include "time_correlated_errors.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "time_cells.h"

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Matrix36 = Eigen::Matrix<double, 3, 6>;

// Half the variance of an error is constant over a strip.
constexpr double kSqrtHalf = 0.70710678118654752;
// The errors of a cheap inertial sensor change within seconds.
constexpr double kSpacing_s = 2.5;
// Limit for the nodes of all strips together: the cost grows with the cube of their number.
constexpr double kMaxErrorNodes = 100.0;
constexpr std::size_t kMaxSeparateStrips = 64;

/// Indices of the unknowns of a strip: its constant at `first`, then its nodes.
struct StripUnknowns {
  double t0_s = 0.0, t1_s = 0.0;
  Index first = 0;
  int nodes = 2;
};

/// Merges neighbouring strips if there are very many, so that they share their errors.
std::vector<StripInterval> Merged(const std::vector<StripInterval>& unsorted) {
  const std::vector<StripInterval> strips = InTime(unsorted);
  const std::size_t together = 1 + (strips.size() - 1) / kMaxSeparateStrips;
  std::vector<StripInterval> merged;
  for (std::size_t k = 0; k < strips.size(); ++k) {
    if (k % together == 0) {
      merged.push_back(strips[k]);
    } else {
      merged.back().t1_s = std::max(merged.back().t1_s, strips[k].t1_s);
    }
  }
  return merged;
}

std::vector<StripUnknowns> LayOut(const std::vector<StripInterval>& strips) {
  double duration_s = 0.0;
  for (const StripInterval& strip : strips) duration_s += strip.t1_s - strip.t0_s;
  const double spacing_s = std::max(kSpacing_s, duration_s / kMaxErrorNodes);
  std::vector<StripUnknowns> unknowns;
  Index next = 3;
  for (const StripInterval& strip : strips) {
    StripUnknowns one{strip.t0_s, strip.t1_s, next, 2};
    one.nodes += static_cast<int>((strip.t1_s - strip.t0_s) / spacing_s);
    next += 6 * (1 + one.nodes);
    unknowns.push_back(one);
  }
  return unknowns;
}

double Outside(const StripUnknowns& strip, double t_s) {
  return std::max({0.0, strip.t0_s - t_s, t_s - strip.t1_s});
}

/// Contribution of an unknown (six columns at `column`) to the error at an epoch. Three unknowns
/// contribute to each epoch.
struct Share {
  Index column = 0;
  double weight = 0.0;
};

std::array<Share, 3> SharesAt(const std::vector<StripUnknowns>& strips, double t_s) {
  const StripUnknowns& strip = *std::min_element(
      strips.begin(), strips.end(),
      [&](const auto& a, const auto& b) { return Outside(a, t_s) < Outside(b, t_s); });
  const double length_s = std::max(strip.t1_s - strip.t0_s, 1e-9);
  const double at =
      std::clamp((t_s - strip.t0_s) / length_s, 0.0, 1.0) * static_cast<double>(strip.nodes - 1);
  const auto before = std::min(static_cast<Index>(at), static_cast<Index>(strip.nodes - 2));
  const double part = at - static_cast<double>(before);
  const Index node = strip.first + 6 * (1 + before);
  return {{{strip.first, 1.0}, {node, 1.0 - part}, {node + 6, part}}};
}

/// The nonzero columns of J for one pair.
struct SparseRows {
  std::array<Index, 7> column{};
  std::array<Matrix36, 7> J;  // the first has three columns
};

SparseRows MakePairJacobian(const PairRows& rows, const std::vector<StripUnknowns>& strips,
                            const Eigen::Matrix<double, 6, 6>& error_sqrt) {
  SparseRows out;
  out.J[0].setZero();
  out.J[0].leftCols<3>() = rows.A;
  std::size_t k = 1;
  const auto add = [&](const Matrix36& B, double t_s) {
    for (const Share& share : SharesAt(strips, t_s)) {
      out.column[k] = share.column;
      out.J[k++] = kSqrtHalf * share.weight * B * error_sqrt;
    }
  };
  add(rows.B_i, rows.t_i_s);
  add(rows.B_j, rows.t_j_s);
  return out;
}

}  // namespace

TimeCorrelatedErrorModel::TimeCorrelatedErrorModel(const std::vector<PairRows>& rows,
                                                   const std::vector<StripInterval>& strips,
                                                   const Eigen::Matrix<double, 6, 6>& error_sqrt,
                                                   const BoresightPrior& prior,
                                                   const std::vector<EffectModel>& blocks)
    : prior_(prior), rows_(3.0 * static_cast<double>(rows.size())) {
  const std::vector<StripUnknowns> unknowns = LayOut(Merged(strips));
  const Index n = unknowns.back().first + 6 * (1 + unknowns.back().nodes);
  first_.push_back(0);
  for (const EffectModel& block : blocks) {
    first_.push_back(first_.back() + block.front().L.cols());
  }
  const Index q = first_.back();
  H_.setZero(n, n);
  G_.setZero(n, q);
  LL_.setZero(q, q);
  b_.setZero(n);
  Lr_.setZero(q);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const SparseRows J = MakePairJacobian(rows[k], unknowns, error_sqrt);
    MatrixXd L(3, q);
    for (std::size_t c = 0; c < blocks.size(); ++c) {
      L.middleCols(first_[c], blocks[c][k].L.cols()) = blocks[c][k].L;
    }
    for (std::size_t a = 0; a < J.J.size(); ++a) {
      const Index size = a == 0 ? 3 : 6;
      const auto J_a = J.J[a].leftCols(size);
      b_.segment(J.column[a], size) += J_a.transpose() * rows[k].w;
      G_.middleRows(J.column[a], size) += J_a.transpose() * L;
      for (std::size_t c = 0; c < J.J.size(); ++c) {
        const Index width = c == 0 ? 3 : 6;
        H_.block(J.column[a], J.column[c], size, width) += J_a.transpose() * J.J[c].leftCols(width);
      }
    }
    LL_ += L.transpose() * L;
    Lr_ += L.transpose() * rows[k].w;
    rr_ += rows[k].w.squaredNorm();
  }
}

VectorXd TimeCorrelatedErrorModel::UnknownScales(const ErrorScale& scale) const {
  VectorXd D = VectorXd::Ones(H_.rows());
  for (Index k = 3; k < D.size(); k += 6) {
    D.segment<3>(k).setConstant(scale.position);
    D.segment<3>(k + 3).setConstant(scale.attitude);
  }
  return D;
}

Eigen::Matrix3d TimeCorrelatedErrorModel::BoresightNormal() const {
  return H_.topLeftCorner<3, 3>() + prior_.weight;
}

TimeCorrelatedErrorModel::ScaleSolution TimeCorrelatedErrorModel::At(
    const ErrorScale& scale) const {
  const double variance = scale.white * scale.white;
  const VectorXd D = UnknownScales(scale) / scale.white;
  MatrixXd N = D.asDiagonal() * H_ * D.asDiagonal();
  N.diagonal().tail(N.rows() - 3).array() += 1.0;
  N.topLeftCorner<3, 3>() += prior_.weight / variance;
  VectorXd b = D.cwiseProduct(b_) / scale.white;
  b.head<3>() += prior_.gradient / variance;
  const MatrixXd G = D.asDiagonal() * G_ / scale.white;
  const Eigen::LLT<MatrixXd> llt(N);
  const MatrixXd Z = llt.solve(G);

  ScaleSolution out;
  const VectorXd pivots = llt.matrixLLT().diagonal();
  out.chi2 = rr_ / variance - b.dot(llt.solve(b));
  out.log_likelihood = -0.5 * out.chi2 - pivots.array().log().sum() - rows_ * std::log(scale.white);
  JointScore& score = out.score;
  score.first = first_;
  score.s = Lr_ / variance - Z.transpose() * b;
  score.A = LL_ / variance - G.transpose() * Z;
  score.A = 0.5 * (score.A + MatrixXd(score.A.transpose()));
  score.signature2 = LL_.diagonal() / variance;
  score.shift = BoresightNormal().llt().solve(G_.topRows<3>());
  return out;
}

Eigen::Matrix3d TimeCorrelatedErrorModel::BoresightCovariance(const ErrorScale& scale) const {
  const Eigen::Matrix3d inverse = BoresightNormal().inverse();
  const Index errors = H_.rows() - 3;
  const MatrixXd moved =
      inverse * H_.topRightCorner(3, errors) * UnknownScales(scale).tail(errors).asDiagonal();
  return scale.white * scale.white * inverse + moved * moved.transpose();
}

double TimeCorrelatedErrorModel::ResidualShare(const VectorXd& effects) const {
  const Eigen::LLT<Eigen::Matrix3d> N(BoresightNormal());
  const Eigen::Vector3d g = b_.head<3>() + prior_.gradient;
  const auto left = [&](double squares, const Eigen::Vector3d& gradient) {
    return squares - gradient.dot(N.solve(gradient));
  };
  const double before = left(rr_, g);
  const double after = left(rr_ + 2.0 * effects.dot(Lr_) + effects.dot(LL_ * effects),
                            g + G_.topRows<3>() * effects);
  return std::max(0.0, after) / std::max(before, std::numeric_limits<double>::min());
}

}  // namespace dn::diagnosis_internal
