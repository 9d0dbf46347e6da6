#include <dn/error.h>
#include <dn/parallel.h>
#include <dn/solvers/residual_form.h>
#include <dn/solvers/restricted_likelihood.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <string>

#include "linearized_impl.h"
#include "sparse/sparse.h"

namespace dn {
namespace solvers_internal {

/// Evaluates the likelihood for one variance vector after another, in one thread. A member of
/// VarianceLikelihood has this type, so it is not in an unnamed namespace.
class Likelihood {
 public:
  /// `analysed` has the analysed pattern of `equations`; null if there are no unknowns.
  Likelihood(const LinearizedNetwork::Impl& network, const sparse::NormalEquations& equations,
             const sparse::Cholesky* analysed)
      : network_(network), equations_(equations) {
    if (analysed != nullptr) cholesky_ = std::make_unique<sparse::Cholesky>(*analysed);
  }

  double At(const Eigen::VectorXd& variance) {
    const Eigen::VectorXd& r = network_.linearization.residual();
    const Eigen::VectorXd weighted = r.cwiseQuotient(variance);
    const double rows = r.dot(weighted) + variance.array().log().sum();
    return -0.5 * (rows + (cholesky_ ? UnknownsTerm(variance, weighted) : 0.0));
  }

 private:
  /// Returns log |N| minus the decrease of the cost by one step.
  double UnknownsTerm(const Eigen::VectorXd& variance, const Eigen::VectorXd& weighted) {
    const Linearization& linearization = network_.linearization;
    equations_.Assemble(network_.layout, linearization, variance.cwiseInverse());
    const Eigen::VectorXd scale = sparse::JacobiScale(equations_.N);
    sparse::ApplyScale(scale, &equations_.N);
    if (!cholesky_->Factorize(equations_.N)) {
      throw RankDeficient("restricted likelihood: the normal matrix cannot be factored");
    }
    const Eigen::VectorXd g = scale.cwiseProduct(linearization.TransposeTimes(weighted));
    return cholesky_->LogDeterminant() - 2.0 * scale.array().log().sum() -
           g.dot(cholesky_->Solve(g).col(0));
  }

  const LinearizedNetwork::Impl& network_;
  sparse::NormalEquations equations_;
  std::unique_ptr<sparse::Cholesky> cholesky_;
};

}  // namespace solvers_internal

namespace {

constexpr int kMaxThreads = 2;
constexpr Eigen::Index kMaxRowsExactParts = 400;

void ExpectRows(Eigen::Index shares, const LinearizedNetwork& linearized) {
  if (shares == linearized.rows()) return;
  throw InvalidInput("restricted likelihood: " + std::to_string(shares) + " shares for " +
                     std::to_string(linearized.rows()) + " residuals");
}

void CheckShare(const Eigen::VectorXd& share) {
  for (Eigen::Index row = 0; row < share.size(); ++row) {
    if (share[row] >= 0.0 && std::isfinite(share[row])) continue;
    throw InvalidInput("restricted likelihood: the variance share of row " + std::to_string(row) +
                       " is " + std::to_string(share[row]) + ", must be finite and at least 0");
  }
}

void CheckTheta(double theta, double largest_share) {
  if (std::isfinite(theta) && 1.0 + theta * largest_share > 0.0) return;
  throw InvalidInput("restricted likelihood: with theta " + std::to_string(theta) +
                     " the smallest variance is " + std::to_string(1.0 + theta * largest_share) +
                     ", must be positive");
}

/// Calls use(R) for matrices with R R^T = M on average, and returns the number of calls.
template <class Use>
double ForResidualParts(const Marginals& marginals, const Use& use) {
  const Eigen::Index rows = marginals.linearized().rows();
  if (rows <= kMaxRowsExactParts) {
    use(marginals.Project(Eigen::MatrixXd::Identity(rows, rows)));
    return 1.0;
  }
  int samples = 0;
  ForEachSampledResidual(marginals, [&](const auto& residual) {
    use(Eigen::MatrixXd(residual));
    ++samples;
  });
  return samples;
}

}  // namespace

double RestrictedLogLikelihood(const Marginals& marginals) {
  const LinearizedNetwork& linearized = marginals.linearized();
  const Eigen::VectorXd& r = linearized.residual();
  const double cost = r.dot(marginals.Project(r).col(0));
  const double log_V = -2.0 * linearized.row_scale().array().log().sum();
  return -0.5 * (cost + log_V + marginals.LogDeterminant());
}

struct VarianceLikelihood::Impl {
  Impl(const LinearizedNetwork& linearized, const Eigen::VectorXd& row_share, int threads)
      : network(linearized.impl()),
        share(row_share),
        equations(network.layout, network.linearization),
        workers(static_cast<std::size_t>(std::clamp(threads, 1, kMaxThreads))) {
    if (network.layout.size() == 0) return;
    analysed = std::make_unique<sparse::Cholesky>(equations.N, equations.blocks, network.layout);
  }

  void Compute(const std::vector<double>& thetas) {
    const std::size_t size = std::min(workers.size(), thetas.size());
    std::vector<double> values(thetas.size());
    ParallelFor(static_cast<int>(size), static_cast<int>(size), [&](int thread) {
      const sparse::SerialBlas serial;
      std::unique_ptr<solvers_internal::Likelihood>& worker =
          workers[static_cast<std::size_t>(thread)];
      if (!worker)
        worker = std::make_unique<solvers_internal::Likelihood>(network, equations, analysed.get());
      for (auto k = static_cast<std::size_t>(thread); k < thetas.size(); k += size) {
        values[k] = worker->At((1.0 + thetas[k] * share.array()).matrix());
      }
    });
    for (std::size_t k = 0; k < thetas.size(); ++k) known[thetas[k]] = values[k];
  }

  const LinearizedNetwork::Impl& network;
  Eigen::VectorXd share;
  sparse::NormalEquations equations;
  std::unique_ptr<const sparse::Cholesky> analysed;
  std::vector<std::unique_ptr<solvers_internal::Likelihood>> workers;  // one per thread
  std::map<double, double> known;
};

VarianceLikelihood::VarianceLikelihood(const LinearizedNetwork& linearized,
                                       const Eigen::VectorXd& share, int threads) {
  ExpectRows(share.size(), linearized);
  CheckShare(share);
  impl_ = std::make_unique<Impl>(linearized, share, threads);
}

VarianceLikelihood::~VarianceLikelihood() = default;
VarianceLikelihood::VarianceLikelihood(VarianceLikelihood&&) noexcept = default;
VarianceLikelihood& VarianceLikelihood::operator=(VarianceLikelihood&&) noexcept = default;

std::vector<double> VarianceLikelihood::At(const std::vector<double>& thetas) {
  const double largest_share = impl_->share.size() > 0 ? impl_->share.maxCoeff() : 0.0;
  std::vector<double> unknown;
  for (const double theta : thetas) {
    CheckTheta(theta, largest_share);
    const bool asked = std::find(unknown.begin(), unknown.end(), theta) != unknown.end();
    if (!asked && impl_->known.count(theta) == 0) unknown.push_back(theta);
  }
  if (!unknown.empty()) impl_->Compute(unknown);
  std::vector<double> values;
  for (const double theta : thetas) values.push_back(impl_->known.at(theta));
  return values;
}

VarianceProfile ProfileVariance(const LinearizedNetwork& linearized, const Eigen::VectorXd& share,
                                const std::vector<double>& thetas, int threads) {
  VarianceLikelihood likelihood(linearized, share, threads);
  std::vector<double> wanted = thetas;
  wanted.push_back(0.0);
  const std::vector<double> l = likelihood.At(wanted);
  VarianceProfile profile{thetas, {}};
  for (std::size_t k = 0; k < thetas.size(); ++k) {
    profile.log_likelihood_ratio.push_back(l[k] - l.back());
  }
  return profile;
}

VarianceScore ScoreVariances(const Marginals& marginals, const Eigen::MatrixXd& shares) {
  ExpectRows(shares.rows(), marginals.linearized());
  const Eigen::Index n = shares.cols();
  Eigen::VectorXd traces = Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd products = Eigen::MatrixXd::Zero(n, n);
  const double samples = ForResidualParts(marginals, [&](const Eigen::MatrixXd& R) {
    std::vector<Eigen::MatrixXd> DR, MDR;
    for (Eigen::Index k = 0; k < n; ++k) {
      DR.emplace_back(shares.col(k).asDiagonal() * R);
      MDR.push_back(marginals.Project(DR.back()));
      traces[k] += R.cwiseProduct(DR.back()).sum();
    }
    for (Eigen::Index k = 0; k < n; ++k) {
      for (Eigen::Index l = 0; l < n; ++l) {
        products(k, l) +=
            DR[static_cast<std::size_t>(k)].cwiseProduct(MDR[static_cast<std::size_t>(l)]).sum();
      }
    }
  });
  const Eigen::VectorXd r2 = marginals.Project(marginals.linearized().residual()).cwiseAbs2();
  VarianceScore score;
  score.u = 0.5 * (shares.transpose() * r2 - traces / samples);
  score.information = 0.25 * (products + products.transpose()) / samples;
  return score;
}

}  // namespace dn
