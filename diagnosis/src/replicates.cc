#include "replicates.h"

#include <dn/distributions.h>
#include <dn/interrupted.h>
#include <dn/parallel.h>
#include <dn/sim/random.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace dn::diagnosis_internal {
namespace {

constexpr int kBatch = 16;

/// Returns the share of values that are at least x, counting x itself.
double Rank(const std::vector<double>& values, double x) {
  const auto above = std::count_if(values.begin(), values.end(), [&](double v) { return v >= x; });
  return (1.0 + static_cast<double>(above)) / (1.0 + static_cast<double>(values.size()));
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
      const Ranks of_replicate{Rank(omnibus_, omnibus_[k]), Rank(largest_, largest_[k]),
                               Rank(library_, library_[k])};
      smallest_.push_back(of_replicate.smallest());
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

  /// Returns the p-value of the smallest of the three ranks, from its distribution over the
  /// replicates.
  double P(const ResidualSummary& flight) const {
    const double smallest = RankFlight(flight).smallest();
    const auto at_most =
        std::count_if(smallest_.begin(), smallest_.end(),
                      [&](double of_replicate) { return of_replicate <= smallest; });
    return (1.0 + static_cast<double>(at_most)) / (1.0 + static_cast<double>(smallest_.size()));
  }

 private:
  Statistics statistics_;
  std::vector<double> omnibus_, largest_, library_, smallest_;
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
