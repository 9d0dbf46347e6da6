#include "rank.h"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <random>

namespace dn {
namespace {

constexpr int kDirections = 8;  ///< dimension of the subspace
/// Numbers of iterations. Each iteration reduces the error by the ratio shift / next eigenvalue.
constexpr int kSubspaceIterations = 5;
constexpr int kProbeIterations = 3;
/// Additional vectors that speed up convergence of the wanted ones.
constexpr Eigen::Index kSpareDirections = 4;
constexpr int kKrylovSteps = 3;  ///< solves per vector between restarts
constexpr int kMostRestarts = 30;
constexpr double kSettled = 1e-11;     ///< relative change of the eigenvalues at convergence
constexpr double kFirstShift = 1e-13;  ///< relative to the unit diagonal of the scaled matrix
constexpr double kLastShift = 1e-7;
constexpr int kSweeps = 30;  ///< sweeps of the rotation to a simple basis
constexpr int kListed = 6;   ///< limit of directions, and of unknowns per direction, in a message
/// Unknowns below this fraction of the largest are not mentioned.
constexpr double kListedShare = 0.1;

Eigen::MatrixXd RandomMatrix(Eigen::Index rows, Eigen::Index cols) {
  std::mt19937 generator(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  Eigen::MatrixXd X(rows, cols);
  for (double& x : X.reshaped()) x = uniform(generator);
  return X;
}

Eigen::MatrixXd Orthonormalised(const Eigen::MatrixXd& X) {
  return Eigen::HouseholderQR<Eigen::MatrixXd>(X).householderQ() *
         Eigen::MatrixXd::Identity(X.rows(), X.cols());
}

/// Returns an orthonormal basis of X, A^-1 X, A^-2 X, ...
Eigen::MatrixXd InverseKrylovBasis(const sparse::Cholesky& cholesky, const Eigen::MatrixXd& X) {
  const Eigen::Index n = X.rows(), width = X.cols();
  Eigen::MatrixXd basis = X;
  for (int step = 0; step < kKrylovSteps && basis.cols() < n; ++step) {
    const Eigen::MatrixXd next = cholesky.Solve(basis.rightCols(width));
    const Eigen::Index columns = std::min(basis.cols() + width, n);
    Eigen::MatrixXd extended(n, columns);
    extended << basis, next.leftCols(columns - basis.cols());
    basis = Orthonormalised(extended);
  }
  return basis;
}

/// Rotates the columns of v among themselves so that each has few large components (quartimax).
Eigen::MatrixXd SimplestBasis(Eigen::MatrixXd v) {
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    for (Eigen::Index p = 0; p < v.cols(); ++p) {
      for (Eigen::Index q = p + 1; q < v.cols(); ++q) {
        const Eigen::ArrayXd a = v.col(p), b = v.col(q);
        const Eigen::ArrayXd u = a.square() - b.square(), w = 2.0 * a * b;
        const double angle =
            0.25 * std::atan2(2.0 * (u * w).sum(), (u.square() - w.square()).sum());
        v.col(p) = std::cos(angle) * a + std::sin(angle) * b;
        v.col(q) = std::cos(angle) * b - std::sin(angle) * a;
      }
    }
  }
  return v;
}

/// Components of one unknown in a direction, over all its epochs.
struct Components {
  std::vector<double> values;
  std::vector<double> epochs_s;

  UnknownShare Summarise(const std::string& name) const {
    UnknownShare share{name, 0.0, std::numeric_limits<double>::infinity(),
                       -std::numeric_limits<double>::infinity()};
    double largest = 0.0, sum = 0.0;
    for (const double value : values) largest = std::max(largest, std::abs(value));
    int count = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::abs(values[i]) < kListedShare * largest) continue;
      ++count;
      sum += values[i] * values[i];
      if (!std::isfinite(epochs_s[i])) continue;
      share.first_s = std::min(share.first_s, epochs_s[i]);
      share.last_s = std::max(share.last_s, epochs_s[i]);
    }
    share.weight = count == 0 ? 0.0 : std::sqrt(sum / count);
    return share;
  }
};

std::string UnknownName(const LinearizedNetwork::Impl::BlockInfo& block, int component) {
  std::string name = block.label.quantity.empty() ? block.name : block.label.quantity;
  if (!block.label.components.empty()) {
    name.append(" ").append(block.label.components[static_cast<std::size_t>(component)]);
  } else if (block.kind.tangent_size > 1) {
    name.append("[").append(std::to_string(component)).append("]");
  }
  return name;
}

std::string ShareText(const UnknownShare& share) {
  std::string text = share.name;
  char number[96];
  if (share.first_s < share.last_s) {
    std::snprintf(number, sizeof(number), ", %.1f..%.1f s", share.first_s, share.last_s);
    text += number;
  } else if (share.first_s == share.last_s) {
    std::snprintf(number, sizeof(number), ", %.1f s", share.first_s);
    text += number;
  }
  std::snprintf(number, sizeof(number), " (%.2f)", share.weight);
  return text + number;
}

/// Returns the k directions with the least information within the span of the columns of Q.
ScaledDirections BestWithin(const Linearization& linearization, const Eigen::VectorXd& scale,
                            const Eigen::MatrixXd& Q, Eigen::Index k) {
  const Eigen::MatrixXd R = linearization.ProductTriangularFactor(scale.asDiagonal() * Q);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(R, Eigen::ComputeFullV);
  ScaledDirections best;
  best.v = Q * svd.matrixV().rowwise().reverse().leftCols(k);
  best.information = svd.singularValues().reverse().head(k).array().square();
  return best;
}

}  // namespace

double ProbeInformation(const Linearization& linearization, const Eigen::VectorXd& scale,
                        const sparse::Cholesky& cholesky) {
  Eigen::MatrixXd x = RandomMatrix(scale.size(), 1);
  for (int i = 0; i < kProbeIterations; ++i) {
    x = cholesky.Solve(x);
    x /= x.norm();
  }
  const double product = linearization.ProductTriangularFactor(scale.asDiagonal() * x)(0, 0);
  return std::isfinite(product) ? product * product : 0.0;
}

ScaledDirections FindFreeDirections(const Linearization& linearization,
                                    const Eigen::VectorXd& scale,
                                    const sparse::SymmetricCsc& scaled_N,
                                    sparse::Cholesky& cholesky) {
  double shift = kFirstShift;
  while (!cholesky.Factorize(scaled_N, shift) && shift < kLastShift) shift *= 10.0;
  Eigen::MatrixXd X = Orthonormalised(
      RandomMatrix(scale.size(), std::min<Eigen::Index>(kDirections, scale.size())));
  for (int i = 0; i < kSubspaceIterations; ++i) X = Orthonormalised(cholesky.Solve(X));

  return BestWithin(linearization, scale, X, X.cols());
}

ScaledDirections FindWeakestDirections(const Linearization& linearization,
                                       const Eigen::VectorXd& scale,
                                       const sparse::Cholesky& cholesky, Eigen::Index k) {
  const Eigen::Index n = scale.size();
  k = std::min(k, n);
  const Eigen::Index width = std::min(k + kSpareDirections, n);
  ScaledDirections best;
  best.v = Orthonormalised(RandomMatrix(n, width));
  best.information = Eigen::VectorXd::Zero(width);
  for (int restart = 0; restart < kMostRestarts; ++restart) {
    const Eigen::VectorXd before = best.information.head(k);
    best = BestWithin(linearization, scale, InverseKrylovBasis(cholesky, best.v), width);
    const Eigen::ArrayXd change = (best.information.head(k) - before).array().abs();
    if ((change <= kSettled * best.information.head(k).array()).all()) break;
  }
  return {best.v.leftCols(k), best.information.head(k)};
}

std::vector<UnknownShare> ComputeUnknownShares(const LinearizedNetwork::Impl& network,
                                               const Eigen::VectorXd& v) {
  std::map<std::string, Components> by_name;
  const UnknownLayout& layout = network.layout;
  for (int p = 0; p < layout.num_blocks(); ++p) {
    const auto& block = network.block(layout.blocks[static_cast<std::size_t>(p)]);
    for (int k = 0; k < layout.block_size(p); ++k) {
      Components& components = by_name[UnknownName(block, k)];
      components.values.push_back(v[layout.offset[static_cast<std::size_t>(p)] + k]);
      components.epochs_s.push_back(block.label.t_s);
    }
  }
  std::vector<UnknownShare> shares;
  double norm2 = 0.0;
  for (const auto& [name, components] : by_name) {
    shares.push_back(components.Summarise(name));
    norm2 += shares.back().weight * shares.back().weight;
  }
  std::stable_sort(shares.begin(), shares.end(), [](const UnknownShare& a, const UnknownShare& b) {
    return a.weight > b.weight;
  });
  const double least = kListedShare * shares.front().weight;
  std::erase_if(shares, [&](const UnknownShare& share) { return share.weight < least; });
  for (UnknownShare& share : shares) share.weight /= std::sqrt(norm2);
  return shares;
}

std::string DescribeShares(const std::vector<UnknownShare>& shares) {
  std::string text;
  for (std::size_t i = 0; i < shares.size() && i < kListed; ++i) {
    if (i > 0) text += ", ";
    text += ShareText(shares[i]);
  }
  return text;
}

std::string DescribeFreeDirections(const LinearizedNetwork::Impl& network,
                                   const Eigen::MatrixXd& v) {
  const Eigen::MatrixXd simple = SimplestBasis(v);
  const Eigen::Index n = simple.cols();
  std::string text = "the measurements leave ";
  text += n >= kDirections ? "at least " + std::to_string(n) : std::to_string(n);
  text += n == 1 ? " direction of the unknowns undetermined: "
                 : " directions of the unknowns undetermined: ";
  for (Eigen::Index i = 0; i < n && i < kListed; ++i) {
    if (i > 0) text += "; ";
    if (n > 1) text.append("(").append(std::to_string(i + 1)).append(") ");
    text += DescribeShares(ComputeUnknownShares(network, simple.col(i)));
  }
  if (n > kListed) text += "; ...";
  return text +
         ". The numbers are weights within a direction. To determine it, give these unknowns a "
         "prior, "
         "set one unknown of each direction constant, or add measurements that separate them";
}

}  // namespace dn
