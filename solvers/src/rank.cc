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

constexpr int kDirections = 8;          ///< dimension of the subspace
constexpr int kSubspaceIterations = 5;  ///< each gains the ratio shift / next eigenvalue
constexpr int kProbeIterations = 3;
constexpr double kFirstShift = 1e-13;  ///< relative to the unit diagonal of the scaled matrix
constexpr double kLastShift = 1e-7;
constexpr int kSweeps = 30;           ///< of the rotation to a simple basis
constexpr int kListed = 6;            ///< directions, and unknowns of one, in a message
constexpr double kListedShare = 0.1;  ///< of the largest: below, an unknown is not mentioned

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

/// The part of one quantity's component in a direction, over all its epochs.
struct Share {
  std::vector<double> values;
  std::vector<double> epochs_s;
  double weight = 0.0;  ///< rms over the epochs that take part
  double first_s = std::numeric_limits<double>::infinity();
  double last_s = -std::numeric_limits<double>::infinity();

  void Summarise() {
    double largest = 0.0, sum = 0.0;
    for (const double value : values) largest = std::max(largest, std::abs(value));
    int count = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (std::abs(values[i]) < kListedShare * largest) continue;
      ++count;
      sum += values[i] * values[i];
      if (!std::isfinite(epochs_s[i])) continue;
      first_s = std::min(first_s, epochs_s[i]);
      last_s = std::max(last_s, epochs_s[i]);
    }
    weight = count == 0 ? 0.0 : std::sqrt(sum / count);
  }
};

std::string UnknownName(const BlockRecord& block, int component) {
  std::string name = block.label.quantity.empty() ? block.name : block.label.quantity;
  if (!block.label.components.empty()) {
    name.append(" ").append(block.label.components[static_cast<std::size_t>(component)]);
  } else if (block.kind.tangent_size > 1) {
    name.append("[").append(std::to_string(component)).append("]");
  }
  return name;
}

std::map<std::string, Share> Shares(const Network& network, const UnknownLayout& layout,
                                    const Eigen::VectorXd& v) {
  std::map<std::string, Share> shares;
  for (int p = 0; p < layout.num_blocks(); ++p) {
    const BlockRecord& block = network.block(layout.blocks[static_cast<std::size_t>(p)]);
    for (int k = 0; k < layout.size_of(p); ++k) {
      Share& share = shares[UnknownName(block, k)];
      share.values.push_back(v[layout.offset[static_cast<std::size_t>(p)] + k]);
      share.epochs_s.push_back(block.label.t_s);
    }
  }
  for (auto& [name, share] : shares) share.Summarise();
  return shares;
}

std::string ShareText(const std::string& name, const Share& share, double norm) {
  std::string text = name;
  char number[96];
  if (share.first_s < share.last_s) {
    std::snprintf(number, sizeof(number), ", %.1f..%.1f s", share.first_s, share.last_s);
    text += number;
  } else if (share.first_s == share.last_s) {
    std::snprintf(number, sizeof(number), ", %.1f s", share.first_s);
    text += number;
  }
  std::snprintf(number, sizeof(number), " (%.2f)", share.weight / norm);
  return text + number;
}

std::string DescribeDirection(const Network& network, const UnknownLayout& layout,
                              const Eigen::VectorXd& v) {
  const std::map<std::string, Share> shares = Shares(network, layout, v);
  std::vector<std::pair<double, const std::string*>> order;
  double norm2 = 0.0;
  for (const auto& [name, share] : shares) {
    order.emplace_back(-share.weight, &name);
    norm2 += share.weight * share.weight;
  }
  std::sort(order.begin(), order.end(), [](const auto& a, const auto& b) {
    return a.first != b.first ? a.first < b.first : *a.second < *b.second;
  });
  std::string text;
  for (std::size_t i = 0; i < order.size() && i < kListed; ++i) {
    if (-order[i].first < kListedShare * -order[0].first) break;
    if (i > 0) text += ", ";
    text += ShareText(*order[i].second, shares.at(*order[i].second), std::sqrt(norm2));
  }
  return text;
}

}  // namespace

double ProbeInformation(const Linearization& linearization, const Eigen::VectorXd& scale,
                        const SparseCholesky& cholesky) {
  Eigen::MatrixXd x = RandomMatrix(scale.size(), 1);
  for (int i = 0; i < kProbeIterations; ++i) {
    x = cholesky.Solve(x);
    x /= x.norm();
  }
  const double product = linearization.TriangularFactorOfProduct(scale.asDiagonal() * x)(0, 0);
  return std::isfinite(product) ? product * product : 0.0;
}

WeakDirections FindWeakDirections(const Linearization& linearization, const Eigen::VectorXd& scale,
                                  const SymmetricCsc& scaled_N, SparseCholesky& cholesky) {
  double shift = kFirstShift;
  while (!cholesky.Factorize(scaled_N, shift) && shift < kLastShift) shift *= 10.0;
  Eigen::MatrixXd X = Orthonormalised(
      RandomMatrix(scale.size(), std::min<Eigen::Index>(kDirections, scale.size())));
  for (int i = 0; i < kSubspaceIterations; ++i) X = Orthonormalised(cholesky.Solve(X));

  const Eigen::MatrixXd R = linearization.TriangularFactorOfProduct(scale.asDiagonal() * X);
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(R, Eigen::ComputeFullV);
  WeakDirections weak;
  weak.v = X * svd.matrixV().rowwise().reverse();
  weak.information = svd.singularValues().reverse().array().square();
  return weak;
}

std::string DescribeFreeDirections(const Network& network, const UnknownLayout& layout,
                                   const Eigen::MatrixXd& v) {
  const Eigen::MatrixXd simple = SimplestBasis(v);
  const Eigen::Index n = simple.cols();
  std::string text = "the measurements leave ";
  text += n >= kDirections ? "at least " + std::to_string(n) : std::to_string(n);
  text += n == 1 ? " direction of the unknowns free: " : " directions of the unknowns free: ";
  for (Eigen::Index i = 0; i < n && i < kListed; ++i) {
    if (i > 0) text += "; ";
    if (n > 1) text.append("(").append(std::to_string(i + 1)).append(") ");
    text += DescribeDirection(network, layout, simple.col(i));
  }
  if (n > kListed) text += "; ...";
  return text +
         ". The numbers are weights within a direction. To fix it, give these unknowns a prior, "
         "hold one of each direction, or add measurements that tell them apart";
}

}  // namespace dn
