#include <dn/calibration/candidate_effects.h>
#include <dn/calibration/model_check.h>
#include <dn/report/distributions.h>
#include <dn/solvers/linearized_network.h>
#include <dn/solvers/prediction.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "effect_screen.h"
#include "model_findings.h"
#include "residual_components.h"

namespace dn {
namespace {

using internal::ResidualComponent;

constexpr int kSamples = 32;
constexpr int kSamplesAtOnce = 8;
constexpr unsigned kSeed = 20240501;
constexpr int kWatchedNodes = 8;
// What averaging over the size of an error costs, against its likeliest size.
constexpr double kPriceOfASizeNats = 2.0;

/// Mean and variance of a quadratic form under the model.
struct Moments {
  double mean = 0.0;
  double variance = 0.0;

  /// Of the chi-square variable with the same ratio of the two, as few as the samples leave
  /// possible: their variance is uncertain by this much, and one square is the least.
  double Dof() const {
    const double dof = 2.0 * mean * mean / variance;
    const double uncertainty = std::sqrt((2.0 + 12.0 / dof) / (kSamples - 1));
    return std::max(1.0, dof / (1.0 + 2.0 * uncertainty));
  }
};

double UpperTail(double energy, const Moments& moments) {
  if (!(moments.variance > 0.0) || !(moments.mean > 0.0)) return 1.0;
  const double dof = moments.Dof();
  return ChiSquareTail(dof * energy / moments.mean, dof);
}

double LowerTail(double energy, const Moments& moments) {
  if (!(moments.variance > 0.0) || !(moments.mean > 0.0)) return 1.0;
  const double dof = moments.Dof();
  return ChiSquareCdf(dof * energy / moments.mean, dof);
}

class Checker {
 public:
  Checker(const Adjustment& adjustment, const Marginals& marginals,
          const TrajectoryResult& trajectory, int threads)
      : network_(*adjustment.network),
        marginals_(marginals),
        trajectory_(trajectory),
        linearized_(network_.net, threads),
        groups_(internal::GroupComponents(network_, linearized_)),
        common_(internal::CommonErrorComponents(network_, linearized_)),
        candidates_(CandidateEffects(network_, threads)) {
    tests_ = static_cast<double>(groups_.size() + common_.size() + candidates_.size());
    Watch();
  }

  ModelCheck Run() {
    CheckPriors();
    SampleMoments();
    FindEffects();
    const Eigen::VectorXd left = ResidualBesideEffects();
    check_.sigma0_beside_effects =
        trajectory_.figures.sigma0 * left.norm() / linearized_.residual().norm();
    CheckGroups(left);
    CheckCommonErrors(left);
    for (const auto& group : check_.groups) Note(group.p_value);
    for (const auto& common : check_.common_errors) Note(common.p_value);
    for (const auto& effect : check_.effects) Note(effect.p_value);
    for (const auto& prior : check_.priors) Note(prior.p_value);
    return std::move(check_);
  }

 private:
  double ForFamily(double p_value) const { return std::min(1.0, p_value * tests_); }
  void Note(double p_value) { check_.p_value = std::min(check_.p_value, p_value); }

  /// The unknowns whose move counts: the boresight, else poses along the trajectory.
  void Watch() {
    if (!network_.pair_edges.empty() && !network_.net.block(network_.boresight.id).held) {
      watched_.push_back(network_.boresight.id);
      check_.of_boresight = true;
    } else {
      const std::size_t n = network_.nodes.size();
      for (int k = 1; k <= kWatchedNodes; ++k) {
        const NodeBlocks& node = network_.nodes[n * static_cast<std::size_t>(k) /
                                                (static_cast<std::size_t>(kWatchedNodes) + 1)];
        watched_.push_back(node.q_mb.id);
        watched_.push_back(node.p_mb.id);
      }
    }
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(linearized_.parameters(),
                                                 3 * static_cast<Eigen::Index>(watched_.size()));
    watched_sigma_.resize(unit.cols());
    for (std::size_t k = 0; k < watched_.size(); ++k) {
      const auto column = 3 * static_cast<Eigen::Index>(k);
      unit.block<3, 3>(linearized_.FirstColumn(watched_[k]), column).setIdentity();
      watched_sigma_.segment<3>(column) =
          marginals_.DiagonalBlock(watched_[k]).diagonal().cwiseSqrt();
    }
    // How far a unit error of each row moves them.
    gain_ = linearized_.Times(marginals_.Solve(unit));
  }

  double InSigmas(const Eigen::VectorXd& move) const {
    return move.cwiseQuotient(watched_sigma_).cwiseAbs().maxCoeff();
  }

  void SampleMoments() {
    const std::size_t n = groups_.size() + common_.size();
    std::vector<std::vector<double>> energies(n);
    std::mt19937_64 generator(kSeed);
    std::normal_distribution<double> normal;
    for (int k = 0; k < kSamples; k += kSamplesAtOnce) {
      Eigen::MatrixXd E(linearized_.rows(), kSamplesAtOnce);
      for (Eigen::Index i = 0; i < E.size(); ++i) E.data()[i] = normal(generator);
      E = linearized_.Project(E, marginals_);
      for (int c = 0; c < kSamplesAtOnce; ++c) {
        for (std::size_t i = 0; i < n; ++i) energies[i].push_back(Component(i).Energy(E.col(c)));
      }
    }
    for (const std::vector<double>& sample : energies) {
      Moments moments;
      for (const double energy : sample) moments.mean += energy / kSamples;
      for (const double energy : sample) {
        moments.variance += std::pow(energy - moments.mean, 2) / (kSamples - 1);
      }
      moments_.push_back(moments);
    }
  }

  const ResidualComponent& Component(std::size_t i) const {
    return i < groups_.size() ? groups_[i] : common_[i - groups_.size()];
  }

  void CheckGroups(const Eigen::VectorXd& beside_effects) {
    std::vector<double> redundancy(static_cast<std::size_t>(linearized_.rows()), 0.0);
    std::vector<double> t_s(redundancy.size(), 0.0);
    std::size_t next = 0;
    for (const LinearizedNetwork::FactorRows& rows : linearized_.factors()) {
      while (next < trajectory_.fits.size() && trajectory_.fits[next].factor != rows.factor) ++next;
      if (next == trajectory_.fits.size()) break;
      for (int k = 0; k < rows.count; ++k) {
        const std::size_t row = static_cast<std::size_t>(rows.first) + static_cast<std::size_t>(k);
        redundancy[row] = trajectory_.fits[next].redundancy[k];
        t_s[row] = network_.net.factor(rows.factor).t_s;
      }
    }
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      GroupCheck group;
      group.name = groups_[g].name;
      for (std::size_t row = 0; row < redundancy.size(); ++row) {
        if (groups_[g].label[row] < 0) continue;
        ++group.observations;
        group.redundancy += redundancy[row];
        const double residual = linearized_.residual()[static_cast<Eigen::Index>(row)];
        const double standardised = residual / std::sqrt(std::max(redundancy[row], 1e-12));
        if (redundancy[row] > kFittedAway &&
            std::abs(standardised) > std::abs(group.worst_standardised)) {
          group.worst_standardised = standardised;
          group.worst_t_s = t_s[row];
        }
      }
      const double energy = groups_[g].Energy(linearized_.residual());
      group.variance_ratio = energy / std::max(group.redundancy, 1e-12);
      group.ratio_beside_effects =
          groups_[g].Energy(beside_effects) / std::max(group.redundancy, 1e-12);
      const Moments moments{group.redundancy, moments_[g].variance};
      group.p_value =
          ForFamily(2.0 * std::min(UpperTail(energy, moments), LowerTail(energy, moments)));
      check_.groups.push_back(std::move(group));
    }
  }

  void CheckCommonErrors(const Eigen::VectorXd& beside_effects) {
    for (std::size_t c = 0; c < common_.size(); ++c) {
      const Moments& moments = moments_[groups_.size() + c];
      CommonErrorCheck common;
      common.name = common_[c].name;
      common.group = common_[c].group;
      const double energy = common_[c].Energy(linearized_.residual());
      common.ratio = energy / std::max(moments.mean, 1e-300);
      common.p_value = ForFamily(UpperTail(energy, moments));
      if (moments.variance > 0.0 && common.ratio > 1.0) {
        common.log_evidence =
            0.5 * moments.Dof() * (common.ratio - 1.0 - std::log(common.ratio)) - kPriceOfASizeNats;
      }
      const double left = common_[c].Energy(beside_effects);
      common.explained = ForFamily(UpperTail(left, moments)) > internal::kFamilyLevel;
      const double variance =
          moments.variance > 0.0 ? 2.0 * (left - moments.mean) / moments.variance : 0.0;
      common.sigma = std::sqrt(std::max(0.0, variance));
      const Eigen::VectorXd move =
          common_[c].SumByLabel(gain_).colwise().norm().transpose() * common.sigma;
      common.damage = InSigmas(move);
      common.worst = WorstLabel(common_[c]);
      check_.common_errors.push_back(std::move(common));
    }
  }

  /// The label whose residuals agree most in their sign.
  std::string WorstLabel(const ResidualComponent& component) const {
    const Eigen::VectorXd sum = component.SumByLabel(linearized_.residual());
    const Eigen::VectorXd count =
        component.SumByLabel(Eigen::VectorXd::Ones(linearized_.rows())).cwiseSqrt();
    Eigen::Index worst = 0;
    sum.cwiseQuotient(count).cwiseAbs().maxCoeff(&worst);
    return component.label_name[static_cast<std::size_t>(worst)];
  }

  void FindEffects() {
    std::vector<EffectModel> models;
    for (const CandidateEffect& candidate : candidates_) models.push_back(candidate.model);
    const JointScore score = ScoreEffects(network_.net, marginals_, models, watched_);
    screen_ =
        internal::ScreenEffects(candidates_, score, {tests_, watched_sigma_, check_.of_boresight});
    check_.effects = screen_.effects;
  }

  /// What the residuals would be with the effects found among the unknowns.
  Eigen::VectorXd ResidualBesideEffects() const {
    if (screen_.chosen.empty()) return linearized_.residual();
    std::vector<int> first_row(static_cast<std::size_t>(network_.net.num_factors()), -1);
    for (const LinearizedNetwork::FactorRows& rows : linearized_.factors()) {
      first_row[static_cast<std::size_t>(rows.factor)] = rows.first;
    }
    Eigen::VectorXd added = Eigen::VectorXd::Zero(linearized_.rows());
    Eigen::Index at = 0;
    for (const std::size_t k : screen_.chosen) {
      const Eigen::Index q = candidates_[k].typical.size();
      for (const EffectPart& part : candidates_[k].model) {
        const int first = first_row[static_cast<std::size_t>(part.factor)];
        if (first >= 0)
          added.segment(first, part.L.rows()) += part.L * screen_.joint.segment(at, q);
      }
      at += q;
    }
    return linearized_.residual() + linearized_.Project(added, marginals_);
  }

  void CheckPriors() {
    for (const LinearizedNetwork::FactorRows& rows : linearized_.factors()) {
      const FactorRecord& record = network_.net.factor(rows.factor);
      const BlockRecord& block = network_.net.block(record.blocks.front());
      const bool is_prior =
          network_.net.groups()[static_cast<std::size_t>(record.group)] == "prior";
      if (!is_prior || std::isfinite(record.t_s)) continue;
      const Prediction prediction = PredictFactor(network_.net, rows.factor, marginals_);
      if (!prediction.determined) continue;
      const double p = ChiSquareTail(prediction.statistic, rows.count);
      check_.priors.push_back({block.name, prediction.statistic, rows.count, ForFamily(p)});
    }
  }

  // A residual of less redundancy says nothing by itself.
  static constexpr double kFittedAway = 1e-6;

  const FlightNetwork& network_;
  const Marginals& marginals_;
  const TrajectoryResult& trajectory_;
  LinearizedNetwork linearized_;
  std::vector<ResidualComponent> groups_, common_;
  std::vector<CandidateEffect> candidates_;
  double tests_ = 1.0;
  std::vector<BlockId> watched_;
  Eigen::VectorXd watched_sigma_;
  Eigen::MatrixXd gain_;  // rows x watched coordinates
  std::vector<Moments> moments_;
  internal::EffectScreen screen_;
  ModelCheck check_;
};

}  // namespace

ModelCheck CheckModel(const Adjustment& adjustment, const Marginals& marginals,
                      const TrajectoryResult& trajectory, int threads) {
  ModelCheck check = Checker(adjustment, marginals, trajectory, threads).Run();
  internal::AddFindings(adjustment, trajectory, &check);
  return check;
}

bool ModelCheck::contradicted() const {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& finding) { return finding.contradicts; });
}

}  // namespace dn
