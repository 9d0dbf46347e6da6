#include "shared_variance.h"

#include <algorithm>
#include <cmath>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int kSizes = 8;
constexpr double kProbabilityOfNone = 0.5;
constexpr double kPriorDof = 18.0;

double Theta(int size) { return std::exp2(size + 1 - kSizes); }

/// The likeliest white variance for a theta, and the log likelihood.
struct Likelihood {
  double white = 1.0;
  double log = 0.0;
};

class Division {
 public:
  Division(const ClusterSums& sums, double sum_of_squares, double redundancy)
      : sums_(sums), q_(sums.left * sums.count), rows_(sums.count.sum()) {
    const auto clusters = static_cast<double>(q_.size());
    const double within = sum_of_squares - sums.energy.cwiseQuotient(sums.count).sum();
    const double within_redundancy = std::max(redundancy - clusters * sums.left, 1e-9);
    within_ = rows_ > clusters ? within * (rows_ - clusters) / within_redundancy : 0.0;
  }

  Likelihood At(double theta) const {
    const VectorXd growth = (1.0 + theta * q_.array()).matrix();
    const double between = sums_.energy.cwiseQuotient(q_.cwiseProduct(growth)).sum();
    Likelihood likelihood;
    likelihood.white = std::max((within_ + between) / rows_, 1e-300);
    likelihood.log = -0.5 * sums_.independent *
                     (rows_ * std::log(likelihood.white) + growth.array().log().sum());
    return likelihood;
  }

 private:
  const ClusterSums& sums_;
  VectorXd q_;
  double rows_, within_;
};

/// One point of the grid.
struct WeightedDivision {
  Index division = 0;
  double theta = 0.0, white = 1.0;
  double log = 0.0;  // likelihood ratio to theta = 0, times the prior
};

/// Returns the log prior probability of each point with theta > 0.
double LogGridPrior(std::size_t divisions) {
  return std::log((1.0 - kProbabilityOfNone) / static_cast<double>(divisions * kSizes));
}

std::vector<WeightedDivision> MakeGrid(const std::vector<ClusterSums>& divisions,
                                       double sum_of_squares, double redundancy) {
  std::vector<WeightedDivision> grid;
  for (std::size_t d = 0; d < divisions.size(); ++d) {
    const Division division(divisions[d], sum_of_squares, redundancy);
    const Likelihood none = division.At(0.0);
    if (d == 0) grid.push_back({0, 0.0, none.white, std::log(kProbabilityOfNone)});
    for (int k = 0; k < kSizes; ++k) {
      const Likelihood some = division.At(Theta(k));
      grid.push_back({static_cast<Index>(d), Theta(k), some.white,
                      some.log - none.log + LogGridPrior(divisions.size())});
    }
  }
  return grid;
}

/// Mean and variance of a quantity over weights.
class WeightedMoments {
 public:
  void Add(double weight, double value) {
    weight_ += weight;
    sum_ += weight * value;
    squares_ += weight * value * value;
  }
  double mean() const { return weight_ > 0.0 ? sum_ / weight_ : 0.0; }
  double sigma() const {
    if (weight_ <= 0.0) return 0.0;
    return std::sqrt(std::max(0.0, squares_ / weight_ - mean() * mean()));
  }

 private:
  double weight_ = 0.0, sum_ = 0.0, squares_ = 0.0;
};

SharedVariance Summarise(const std::vector<WeightedDivision>& grid,
                         const std::vector<double>& lengths_m) {
  SharedVariance posterior;
  posterior.shared = VectorXd::Zero(static_cast<Index>(lengths_m.size()));
  double most = grid.front().log, sum = 0.0;
  for (const WeightedDivision& point : grid) most = std::max(most, point.log);
  for (const WeightedDivision& point : grid) sum += std::exp(point.log - most);
  WeightedMoments white, size, length;
  for (const WeightedDivision& point : grid) {
    const double probability = std::exp(point.log - most) / sum;
    white.Add(probability, point.white);
    if (point.theta == 0.0) continue;
    posterior.probability += probability;
    posterior.shared[point.division] += probability * point.theta * point.white;
    size.Add(probability, std::sqrt(point.theta * point.white));
    length.Add(probability, lengths_m[static_cast<std::size_t>(point.division)]);
  }
  posterior.white = white.mean();
  posterior.size = size.mean();
  posterior.size_sigma = size.sigma();
  posterior.length_m = length.mean();
  posterior.length_sigma_m = length.sigma();
  return posterior;
}

}  // namespace

ClusterSums::ClusterSums(const ResidualForm& form, const FormMoments& moments,
                         const VectorXd& residual)
    : energy(form.SumByLabel(residual).cwiseAbs2()),
      count(form.SumByLabel(VectorXd::Ones(residual.size()))) {
  left = std::clamp(moments.mean / count.sum(), 1e-6, 1.0);
  if (moments.variance <= 0.0) return;
  const double dof = 2.0 * moments.mean * moments.mean / moments.variance;
  independent = std::min(1.0, dof * count.squaredNorm() / (count.sum() * count.sum()));
}

SharedVariance EstimateSharedVariance(const std::vector<ClusterSums>& divisions,
                                      const std::vector<double>& lengths_m, double sum_of_squares,
                                      double redundancy) {
  if (divisions.empty()) return {};
  return Summarise(MakeGrid(divisions, sum_of_squares, redundancy), lengths_m);
}

SharedVariance PriorSharedVariance(const std::vector<double>& lengths_m) {
  std::vector<WeightedDivision> grid{{0, 0.0, 1.0, std::log(kProbabilityOfNone)}};
  for (std::size_t d = 0; d < lengths_m.size(); ++d) {
    for (int k = 0; k < kSizes; ++k) {
      grid.push_back({static_cast<Index>(d), Theta(k), 1.0, LogGridPrior(lengths_m.size())});
    }
  }
  return Summarise(grid, lengths_m);
}

double PosteriorNoiseVariance(double variance_ratio, double dof) {
  return (kPriorDof + dof * variance_ratio) / (kPriorDof + dof);
}

double PosteriorNoiseSigma(double variance_ratio, double dof) {
  // An inverse gamma distribution with the shape a has the standard deviation mean / sqrt(a - 2),
  // and its dof is 2 (a - 1).
  return PosteriorNoiseVariance(variance_ratio, dof) / std::sqrt(0.5 * (kPriorDof + dof) - 1.0);
}

double PriorNoiseSigma() { return PosteriorNoiseSigma(1.0, 0.0); }

}  // namespace dn::diagnosis_internal
