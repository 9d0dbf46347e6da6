#include "replicates.h"

#include <dn/distributions.h>
#include <dn/interrupted.h>
#include <dn/parallel.h>
#include <dn/sim/random.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

namespace dn::diagnosis_internal {
namespace {

constexpr int kBatch = 16;

double CountAtLeast(const std::vector<double>& values, double x) {
  return static_cast<double>(
      std::count_if(values.begin(), values.end(), [&](double v) { return v >= x; }));
}

/// Returns the share of values that are at least x, counting x itself as one more value.
double Rank(const std::vector<double>& values, double x) {
  return (1.0 + CountAtLeast(values, x)) / (1.0 + static_cast<double>(values.size()));
}

struct Moments {
  double mean = 0.0, variance = 0.0;

  explicit Moments(const std::vector<double>& values) {
    const auto n = static_cast<double>(values.size());
    for (const double v : values) mean += v / n;
    for (const double v : values) variance += (v - mean) * (v - mean) / (n - 1.0);
    variance = std::max(variance, 1e-300);
  }
};

/// Returns the probability beyond x of the scaled chi-square with the moments of positive values.
double ChiSquareBeyond(const std::vector<double>& values, double x) {
  const Moments of(values);
  return ChiSquareTail(2.0 * of.mean * x / of.variance, 2.0 * of.mean * of.mean / of.variance);
}

/// Returns the probability beyond x of Gumbel's distribution of maxima with the moments of values.
double GumbelBeyond(const std::vector<double>& values, double x) {
  constexpr double kEulerGamma = 0.57721566490153286;
  const Moments of(values);
  const double scale = std::sqrt(6.0 * of.variance) / std::numbers::pi;
  const double mode = of.mean - kEulerGamma * scale;
  return -std::expm1(-std::exp(-(x - mode) / scale));
}

/// The three statistics that compare a flight with its replicates.
class Statistics {
 public:
  Statistics(const ReplicateSet& replicates, std::size_t count) {
    const auto n = static_cast<double>(count);
    mean_ = Eigen::VectorXd::Zero(replicates.all[0].locations.size());
    for (std::size_t k = 0; k < count; ++k) mean_ += replicates.all[k].locations / n;
    sigma_ = Eigen::VectorXd::Zero(mean_.size());
    for (std::size_t k = 0; k < count; ++k) {
      sigma_ += (replicates.all[k].locations - mean_).cwiseAbs2() / (n - 1.0);
    }
    sigma_ = sigma_.cwiseMax(1e-300).cwiseSqrt();
    Eigen::MatrixXd C = kShrunk * Eigen::MatrixXd::Identity(mean_.size(), mean_.size());
    for (std::size_t k = 0; k < count; ++k) {
      const Eigen::VectorXd z = Z(replicates.all[k]);
      C.selfadjointView<Eigen::Lower>().rankUpdate(z, (1.0 - kShrunk) / (n - 1.0));
    }
    factor_.compute(C.selfadjointView<Eigen::Lower>());
  }

  Eigen::VectorXd Z(const ResidualSummary& of) const {
    return (of.locations - mean_).cwiseQuotient(sigma_);
  }
  double Omnibus(const ResidualSummary& of) const {
    return factor_.matrixL().solve(Z(of)).squaredNorm();
  }
  double Largest(const ResidualSummary& of) const { return Z(of).cwiseAbs().maxCoeff(); }
  static double Library(const ResidualSummary& of) {
    return of.log_evidence.size() > 0 ? of.log_evidence.maxCoeff() : 0.0;
  }

  const Eigen::VectorXd& mean() const { return mean_; }
  const Eigen::VectorXd& sigma() const { return sigma_; }

 private:
  Eigen::VectorXd mean_, sigma_;
  Eigen::LLT<Eigen::MatrixXd> factor_;
};

/// Shares of replicates that differ from the model at least as much as one flight.
struct Ranks {
  double omnibus = 1.0, largest = 1.0, library = 1.0;

  double smallest() const { return std::min({omnibus, largest, library}); }
};

/// Ranks flights among replicates; some replicates standardise the statistics, others rank them.
class Ranking {
 public:
  /// Standardises by the replicates [0, standardising) and ranks by [standardising, past).
  Ranking(const ReplicateSet& replicates, std::size_t standardising, std::size_t past)
      : statistics_(replicates, standardising) {
    for (std::size_t k = standardising; k < past; ++k) {
      omnibus_.push_back(statistics_.Omnibus(replicates.all[k]));
      largest_.push_back(statistics_.Largest(replicates.all[k]));
      library_.push_back(Statistics::Library(replicates.all[k]));
    }
    for (std::size_t k = 0; k < omnibus_.size(); ++k) {
      at_least_.push_back({CountAtLeast(omnibus_, omnibus_[k]), CountAtLeast(largest_, largest_[k]),
                           CountAtLeast(library_, library_[k])});
    }
  }

  const Statistics& statistics() const { return statistics_; }
  const std::vector<double>& omnibus() const { return omnibus_; }
  const std::vector<double>& library() const { return library_; }

  Ranks RankFlight(const ResidualSummary& flight) const {
    return {Rank(omnibus_, statistics_.Omnibus(flight)),
            Rank(largest_, statistics_.Largest(flight)),
            Rank(library_, Statistics::Library(flight))};
  }

  /// Returns the p-value of the smallest of the three ranks among the flight and the replicates.
  /// All n + 1 are alike under the model, so each of them is ranked among all.
  double P(const ResidualSummary& flight) const {
    const double smallest = RankFlight(flight).smallest();
    const double omnibus = statistics_.Omnibus(flight), largest = statistics_.Largest(flight),
                 library = Statistics::Library(flight);
    const double n = static_cast<double>(omnibus_.size());
    double at_most = 1.0;
    for (std::size_t k = 0; k < omnibus_.size(); ++k) {
      const double first = std::min({at_least_[k][0] + (omnibus >= omnibus_[k] ? 1.0 : 0.0),
                                     at_least_[k][1] + (largest >= largest_[k] ? 1.0 : 0.0),
                                     at_least_[k][2] + (library >= library_[k] ? 1.0 : 0.0)});
      if (first / (1.0 + n) <= smallest) at_most += 1.0;
    }
    return at_most / (1.0 + n);
  }

  /// Returns a p-value for a flight beyond all replicates, by distributions fitted to them. They
  /// are a scaled chi-square for the omnibus and Gumbel's for the two maxima, corrected for three
  /// tests.
  double BeyondReplicates(const ResidualSummary& flight) const {
    constexpr double kLeast = 1e-300;
    return std::clamp(3.0 * std::min({ChiSquareBeyond(omnibus_, statistics_.Omnibus(flight)),
                                      GumbelBeyond(largest_, statistics_.Largest(flight)),
                                      GumbelBeyond(library_, Statistics::Library(flight))}),
                      kLeast, 1.0);
  }

 private:
  Statistics statistics_;
  std::vector<double> omnibus_, largest_, library_;
  // Number of replicates with at least the value of each replicate; omnibus, largest, library.
  std::vector<std::array<double, 3>> at_least_;
};

/// Returns step-down adjusted p-values (Westfall and Young). The largest |z| is compared with the
/// maximum over all statistics, the next one with the maximum over the rest. The p-values never
/// decrease along this order.
Eigen::VectorXd StepDown(const Eigen::VectorXd& z,
                         const std::vector<Eigen::VectorXd>& of_replicates) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(z.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](Eigen::Index a, Eigen::Index b) { return std::abs(z[a]) < std::abs(z[b]); });
  std::vector<double> largest(of_replicates.size(), 0.0);
  Eigen::VectorXd p(z.size());
  for (const Eigen::Index at : order) {  // from the smallest, so that the maxima grow
    for (std::size_t b = 0; b < of_replicates.size(); ++b) {
      largest[b] = std::max(largest[b], std::abs(of_replicates[b][at]));
    }
    p[at] = Rank(largest, std::abs(z[at]));
  }
  double before = 0.0;
  for (auto at = order.rbegin(); at != order.rend(); ++at) {
    p[*at] = std::max(p[*at], before);
    before = p[*at];
  }
  return p;
}

}  // namespace

ResidualSummary SummariseResiduals(const Screen& screen, const Locations& locations,
                                   const Eigen::VectorXd& residual, const Eigen::VectorXd& scores) {
  ResidualSummary appearance;
  appearance.locations = locations.Evaluate(residual);
  appearance.log_evidence = screen.LogEvidences(scores);
  appearance.size_nats = locations.SizeNats(residual);
  appearance.pair_rms_m = locations.PairRms(residual);
  appearance.gnss_rms_m = locations.GnssRms(residual);
  return appearance;
}

ReplicateSet MakeReplicates(const Marginals& marginals, const Screen& screen,
                            const Locations& locations, const ReplicateOptions& options) {
  const LinearizedNetwork& linearized = marginals.linearized();
  ReplicateSet replicates;
  replicates.all.resize(static_cast<std::size_t>(options.count));
  for (int first = 0; first < options.count; first += kBatch) {
    if (options.interrupted && options.interrupted()) throw Interrupted();
    if (options.progress) options.progress(static_cast<double>(first) / options.count);
    const int batch = std::min(kBatch, options.count - first);
    Eigen::MatrixXd E(linearized.rows(), batch);
    for (int k = 0; k < batch; ++k) {
      Random random(options.seed, "twin/" + std::to_string(first + k));
      for (Eigen::Index row = 0; row < E.rows(); ++row) E(row, k) = random.Normal();
    }
    const Eigen::MatrixXd R = marginals.Project(E);
    const Eigen::MatrixXd S = screen.Scores(linearized, R);
    ParallelFor(batch, options.threads, [&](int k) {
      const auto replicate = static_cast<std::size_t>(first) + static_cast<std::size_t>(k);
      replicates.all[replicate] = SummariseResiduals(screen, locations, R.col(k), S.col(k));
    });
  }
  return replicates;
}

std::vector<Eigen::Index> ReplicateTest::LargestFirst() const {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(z.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(),
            [&](Eigen::Index a, Eigen::Index b) { return std::abs(z[a]) > std::abs(z[b]); });
  return order;
}

ReplicateTest CompareWithReplicates(const ResidualSummary& flight, const ReplicateSet& replicates) {
  const Ranking ranking(replicates, replicates.all.size() / 2, replicates.all.size());
  const Statistics& statistics = ranking.statistics();
  const Ranks ranks = ranking.RankFlight(flight);
  ReplicateTest test;
  test.mean = statistics.mean();
  test.sigma = statistics.sigma();
  test.z = statistics.Z(flight);
  test.omnibus = statistics.Omnibus(flight);
  test.omnibus_of_replicates = ranking.omnibus();
  test.omnibus_mean = std::accumulate(ranking.omnibus().begin(), ranking.omnibus().end(), 0.0) /
                      static_cast<double>(ranking.omnibus().size());
  test.p_omnibus = ranks.omnibus;
  test.p_largest = ranks.largest;
  test.p_library = ranks.library;
  test.p_value = ranking.P(flight);
  const bool beyond_all =
      ranks.smallest() * (1.0 + static_cast<double>(ranking.omnibus().size())) < 1.5;
  if (beyond_all) test.p_value = std::min(test.p_value, ranking.BeyondReplicates(flight));
  std::vector<Eigen::VectorXd> z_of_replicates;
  for (std::size_t k = replicates.all.size() / 2; k < replicates.all.size(); ++k) {
    z_of_replicates.push_back(statistics.Z(replicates.all[k]));
  }
  test.p_adjusted = StepDown(test.z, z_of_replicates);
  std::vector<double> library = ranking.library();
  std::sort(library.begin(), library.end());
  test.evidence_95 = library[static_cast<std::size_t>(0.95 * static_cast<double>(library.size()))];
  return test;
}

double TestReplicateConsistency(const ReplicateSet& replicates) {
  const std::size_t third = replicates.all.size() / 3;
  if (third < 2) return 1.0;
  const Ranking ranking(replicates, third, 2 * third);
  std::vector<double> p_values;
  for (std::size_t k = 2 * third; k < replicates.all.size(); ++k) {
    p_values.push_back(ranking.P(replicates.all[k]));
  }
  return UniformityPValue(std::move(p_values), static_cast<double>(third));
}

}  // namespace dn::diagnosis_internal
