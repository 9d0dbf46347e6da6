#include <dn/adjustment/words.h>
#include <dn/diagnosis/model_check.h>
#include <dn/diagnosis/scanner_mountings.h>
#include <dn/distributions.h>
#include <dn/effects/effect_table.h>
#include <dn/files/flight.h>
#include <dn/files/scanners.h>
#include <dn/parallel.h>
#include <dn/solvers/fit_check.h>
#include <dn/solvers/prediction.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "clock_estimates.h"
#include "competing_effects.h"
#include "control_check.h"
#include "detectability.h"
#include "discrepancies.h"
#include "effect_rows.h"
#include "gnss_process.h"
#include "gnss_runs.h"
#include "model_findings.h"
#include "network_hypotheses.h"
#include "node_changes.h"
#include "noise_beyond_model.h"
#include "noise_retest.h"
#include "score_selection.h"
#include "smallest_p_value.h"
#include "tested_forms.h"
#include "unmodelled.h"

namespace dn {
namespace diagnosis_internal {
namespace {

constexpr int kWatchedNodes = 8;
// A residual beyond this many sigmas is an outlier, whatever the distribution of the noise.
constexpr double kIsolatedSigmas = 10.0;
// An error of a row with a smaller redundancy number shows more in other rows than in its own.
constexpr double kControlledRedundancy = 0.1;
// Cost, in nats, of averaging the evidence over the size of an error instead of taking the
// likeliest size.
constexpr double kSizeAveragingNats = 2.0;
constexpr int kScoreDraws = 400;

std::vector<Hypothesis> MakeDiscrepancies(const FlightNetwork& network) {
  if (network.pairs().edges().empty()) return {};
  std::vector<Hypothesis> discrepancies;
  for (std::size_t k = 0; k < NumScanners(network.flight().config); ++k) {
    discrepancies.push_back(LaserByScanAngle(network, k));
  }
  const std::vector<StripInterval> strips = FindStrips(network.flight());
  if (strips.size() > 1 && strips.size() <= kMaxJointStrips) {
    discrepancies.push_back(LaserByStrip(strips));
  }
  return discrepancies;
}

class Checker {
 public:
  Checker(const Adjustment& adjustment, const Marginals& marginals,
          const TrajectoryResult& trajectory, int threads)
      : adjustment_(adjustment),
        network_(*adjustment.network),
        marginals_(marginals),
        trajectory_(trajectory),
        linearized_(marginals.linearized()),
        prior_(MakeUnmodelledPrior(network_.flight().config)),
        threads_(threads) {}

  ModelCheck Run() {
    auto sums =
        Beside(threads_, [&] { forms_ = MakeTestedForms(network_, marginals_, !prior_.pure()); });
    library_ = MakeNetworkHypotheses(network_, threads_, MakeDiscrepancies(network_));
    gnss_process_ = AddGnssProcess(network_, linearized_, &library_);
    AddControlShift();
    Watch();
    const JointScore score = ScoreHypotheses();
    sums.get();
    family_.tests = static_cast<double>(forms_.tested + library_.hypotheses.size());
    CheckPriors();
    const UnmodelledUnknowns unmodelled(library_, prior_, score, gnss_process_);
    FindCompeting(score);
    FindClocks(score);
    TakeUnmodelled(unmodelled);
    TestControl(score, unmodelled);
    JointScore conditioned = unmodelled.Conditioned();
    conditioned.shift.conservativeResize(family_.watched_sigma.size(), Eigen::NoChange);
    FindEffects(conditioned);
    residual_ = ResidualWith(library_, marginals_, unmodelled.estimate());
    CheckGroups();
    NoiseRetest retest(marginals_, library_, forms_, unmodelled, family_);
    if (HasNoiseBeyondModel()) {
      retest.Estimate(conditioned, residual_, check_.groups, &selection_);
    } else {
      retest.TakeResidual(residual_, selection_);
    }
    TakeEffects(retest);
    TakeNoise(unmodelled, retest.noise());
    CheckAllDiscrepancies(unmodelled);
    CheckCommonErrors(retest);
    check_.gnss_runs = CheckGnssRuns(network_, marginals_, watched_, family_);
    check_.p_value = FamilyPValue(smallest_p_, check_.effective_tests);
    return std::move(check_);
  }

 private:
  /// Selects the unknowns whose shift counts: the boresight, or else poses along the trajectory.
  void Watch() {
    if (!network_.pairs().edges().empty() &&
        !network_.net().block(network_.calibration().boresight().id).held) {
      watched_.push_back(network_.calibration().boresight().id);
    } else {
      family_.of_boresight = false;
      const std::size_t n = network_.nodes().size();
      for (int k = 1; k <= kWatchedNodes; ++k) {
        const NodeBlocks& node = network_.nodes()[n * static_cast<std::size_t>(k) /
                                                  (static_cast<std::size_t>(kWatchedNodes) + 1)];
        watched_.push_back(node.q_mb.id);
        watched_.push_back(node.p_mb.id);
      }
    }
    check_.of_boresight = family_.of_boresight;
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(linearized_.parameters(),
                                                 3 * static_cast<Eigen::Index>(watched_.size()));
    family_.watched_sigma.resize(unit.cols());
    for (std::size_t k = 0; k < watched_.size(); ++k) {
      const auto column = 3 * static_cast<Eigen::Index>(k);
      unit.block<3, 3>(linearized_.FirstColumn(watched_[k]), column).setIdentity();
      family_.watched_sigma.segment<3>(column) =
          marginals_.DiagonalBlock(watched_[k]).diagonal().cwiseSqrt();
    }
    // The shift of the watched unknowns by a unit error of each row.
    gain_ = linearized_.Times(marginals_.Solve(unit));
  }

  /// Returns true if one measurement explains the misfit of its group. An error of a row shows in
  /// the row itself only if its redundancy number is large enough; else it shows in other rows.
  bool IsIsolatedRow(const GroupCheck& group, const RowFit& worst) const {
    if (group.p_value > kFamilyLevel || std::abs(worst.standardised) < kIsolatedSigmas)
      return false;
    if (linearized_.group(worst.row.factor).kind != FactorGroup::Kind::kMeasurement) return false;
    if (worst.redundancy < kControlledRedundancy) return false;
    // Without the row, the sum of squares of all groups is smaller by the square of its w.
    const double rest = group.variance_ratio * group.redundancy - std::pow(worst.standardised, 2);
    return rest <= kLargestVarianceRatio * group.redundancy;
  }

  /// Returns the p-value of one of the tests for the family of all tests.
  double FamilyWise(double p_value) {
    smallest_p_ = std::min(smallest_p_, p_value);
    return family_.FamilyWise(p_value);
  }

  void CheckGroups() {
    Eigen::VectorXd redundancy(static_cast<Eigen::Index>(forms_.channels));
    for (std::size_t g = 0; g < forms_.channels; ++g) {
      TestedGroup tested = CheckGroup(g, residual_);
      if (gnss_process_) {
        // A wide process absorbs a part of an outlier, which then looks like several errors.
        TestedGroup pure = CheckGroup(g, linearized_.residual());
        if (pure.group.isolated) tested = std::move(pure);
      }
      smallest_p_ = std::min(smallest_p_, tested.p_value);
      redundancy[static_cast<Eigen::Index>(g)] = tested.group.redundancy;
      check_.groups.push_back(std::move(tested.group));
    }
    check_.effective_tests +=
        EffectiveTests(SmallestFormPValues(forms_.TestedMoments(), forms_.energies, redundancy));
  }

  /// A tested group with its p-value as that of a single test.
  struct TestedGroup {
    GroupCheck group;
    double p_value = 1.0;
  };

  TestedGroup CheckGroup(std::size_t g, const Eigen::VectorXd& residual) const {
    const ChannelFit fit = TestChannel(linearized_, residual, forms_.all[g], forms_.moments[g],
                                       trajectory_.redundancy);
    GroupCheck group;
    group.name = fit.name;
    group.observations = fit.observations;
    group.redundancy = fit.redundancy;
    group.variance_ratio = fit.variance_ratio;
    group.p_value = family_.FamilyWise(fit.p_value);
    group.worst_t_s = fit.worst.row.t_s;
    group.worst_standardised = fit.worst.standardised;
    group.isolated = IsIsolatedRow(group, fit.worst);
    return {std::move(group), fit.p_value};
  }

  void CheckCommonErrors(const NoiseRetest& retest) {
    for (std::size_t c = forms_.channels; c < forms_.tested; ++c) {
      const ResidualForm& form = forms_.all[c];
      const FormMoments& moments = forms_.moments[c];
      CommonErrorCheck common;
      common.name = form.name;
      common.group = form.channel;
      const double energy = form.Energy(residual_);
      common.ratio = energy / std::max(moments.mean, 1e-300);
      common.p_value = FamilyWise(moments.UpperTail(energy));
      if (moments.variance > 0.0 && common.ratio > 1.0) {
        common.log_evidence = 0.5 * moments.Dof() * (common.ratio - 1.0 - std::log(common.ratio)) -
                              kSizeAveragingNats;
      }
      const double left = form.Energy(retest.left());
      common.explained = family_.FamilyWise(retest.Moments(c).UpperTail(left)) > kFamilyLevel;
      const double variance =
          moments.variance > 0.0 ? 2.0 * (left - moments.mean) / moments.variance : 0.0;
      common.sigma = std::sqrt(std::max(0.0, variance));
      const Eigen::VectorXd move =
          form.SumByLabel(gain_).colwise().norm().transpose() * common.sigma;
      common.max_shift_sigmas = family_.InSigmas(move);
      if (common.p_value <= kFamilyLevel) {
        common.worst = WorstLabel(form);
        common.covered = IsCovered(common, retest, c, left);
      }
      check_.common_errors.push_back(std::move(common));
    }
  }

  /// Returns whether the noise in the watched sigmas explains a common error, or leaves too little
  /// of it to count. `energy` is that of the residuals with all effects.
  bool IsCovered(const CommonErrorCheck& common, const NoiseRetest& retest, std::size_t form,
                 double energy) const {
    const FormMoments& stated = forms_.moments[form];
    const FormMoments& noisy = retest.Moments(form);
    const double own = retest.noise().Growth(forms_.all[form], stated);
    if (own <= 1.0 && noisy.mean == stated.mean) return false;
    if (family_.FamilyWise(noisy.UpperTail(energy / own)) > kFamilyLevel) return true;
    const double left =
        std::max(0.0, energy - own * noisy.mean) / std::max(energy - stated.mean, 1e-300);
    return common.max_shift_sigmas * std::sqrt(left) <= kMaxShiftInSigmas;
  }

  /// Returns the label whose residuals agree most in their sign.
  std::string WorstLabel(const ResidualForm& form) const {
    const Eigen::VectorXd sum = form.SumByLabel(residual_);
    const Eigen::VectorXd count =
        form.SumByLabel(Eigen::VectorXd::Ones(linearized_.rows())).cwiseSqrt();
    Eigen::Index worst = 0;
    sum.cwiseQuotient(count).cwiseAbs().maxCoeff(&worst);
    return form.label_name[static_cast<std::size_t>(worst)];
  }

  /// Returns the estimated effects, then the corrections of beams.
  std::vector<BlockId> ReportedUnknowns() const {
    std::vector<BlockId> unknowns = EffectUnknowns(network_);
    for (const BlockId block : BeamBlocks(network_)) unknowns.push_back(block);
    return unknowns;
  }

  /// Returns the score of the hypotheses. Its shift has the watched unknowns first, then the
  /// ReportedUnknowns, then the mountings of several scanners, the tie points, and the control.
  JointScore ScoreHypotheses() const {
    std::vector<BlockId> shifted = watched_;
    for (const BlockId unknown : ReportedUnknowns()) shifted.push_back(unknown);
    for (const BlockId unknown : MountingUnknowns(network_)) shifted.push_back(unknown);
    for (const ControlNode& tie : network_.ties().points()) shifted.push_back(tie.deviation);
    for (const BlockId block : ControlDeviations(network_)) shifted.push_back(block);
    return ScoreEffects(marginals_, library_.blocks, shifted);
  }

  void FindCompeting(const JointScore& score) {
    check_.competing_effects = FindCompetingEffects(network_, marginals_, library_, score, watched_,
                                                    EffectUnknowns(network_), family_);
  }

  void AddControlShift() {
    EffectModel columns = ControlShiftColumns(network_);
    if (!columns.empty()) control_shift_ = library_.AddBlock(std::move(columns));
  }

  void TestControl(const JointScore& score, const UnmodelledUnknowns& unmodelled) {
    Eigen::Index rows = 0;
    for (const BlockId block : ControlDeviations(network_)) {
      rows += network_.net().block(block).kind.tangent_size;
    }
    check_.control = CheckControl({adjustment_, marginals_, unmodelled, score.shift.rows() - rows,
                                   family_.of_boresight, control_shift_});
  }

  /// Takes what unmodelled effects change: from here on, the watched sigmas contain it.
  void TakeUnmodelled(const UnmodelledUnknowns& unmodelled) {
    if (unmodelled.empty()) return;
    const Eigen::VectorXd change = unmodelled.Correction();
    const Eigen::MatrixXd added = unmodelled.AddedCovariance();
    const Eigen::Index watched = family_.watched_sigma.size();
    family_.watched_sigma =
        (family_.watched_sigma.cwiseAbs2() + added.diagonal().head(watched)).cwiseSqrt();
    UnmodelledEffects& effects = check_.unmodelled.emplace();
    effects.nodes = NodeChanges(network_, marginals_, library_, unmodelled);
    effects.contributions = unmodelled.Contributions(AngleRows());
    if (unmodelled.process()) effects.gnss_process_usual = IsUsualSize(*unmodelled.process());
    if (family_.of_boresight) {
      effects.boresight_rad = change.head<3>();
      effects.covariance_rad2 = added.topLeftCorner<3, 3>();
      effects.posterior = unmodelled.Posterior();
    }
    Eigen::Index row = watched;
    for (const BlockId unknown : ReportedUnknowns()) {
      const BlockRecord& block = network_.net().block(unknown);
      const Eigen::Index size = block.kind.tangent_size;
      effects.unknowns.push_back(
          {block.name, change.segment(row, size), added.diagonal().segment(row, size)});
      row += size;
    }
    TakeMountings(unmodelled, row, &effects);
    effects.posterior.first_tie =
        row + 3 * static_cast<Eigen::Index>(MountingUnknowns(network_).size());
  }

  /// Takes what unmodelled effects change in the mountings of several scanners. `row` is the first
  /// of MountingUnknowns in the shift of the score.
  void TakeMountings(const UnmodelledUnknowns& unmodelled, Eigen::Index row,
                     UnmodelledEffects* effects) {
    first_mounting_ = row;
    const std::vector<BlockId> unknowns = MountingUnknowns(network_);
    const auto size = 3 * static_cast<Eigen::Index>(unknowns.size());
    if (size == 0) return;
    effects->mountings = unmodelled.Correction().segment(row, size);
    effects->mountings_covariance = unmodelled.AddedCovariance().block(row, row, size, size);
    for (const ScannerBlocks& scanner : network_.calibration().scanners()) {
      const auto at = std::find(unknowns.begin(), unknowns.end(), scanner.boresight.id);
      effects->scanner_contributions.emplace_back();
      if (at == unknowns.end()) continue;
      effects->scanner_contributions.back() =
          unmodelled.Contributions({row + 3 * static_cast<Eigen::Index>(at - unknowns.begin())});
    }
  }

  /// Takes the noise beyond the stated one into the mountings of several scanners.
  void TakeMountingNoise(const NoiseBeyondModel& noise, const Eigen::MatrixXd& gain_of_effects,
                         UnmodelledEffects* effects) {
    const Eigen::Index size = effects->mountings.size();
    if (size == 0) return;
    Eigen::MatrixXd unit = Eigen::MatrixXd::Zero(linearized_.parameters(), size);
    Eigen::Index column = 0;
    for (const BlockId unknown : MountingUnknowns(network_)) {
      unit.block<3, 3>(linearized_.FirstColumn(unknown), column).setIdentity();
      column += 3;
    }
    const Eigen::MatrixXd gain = linearized_.Times(marginals_.Solve(unit)) -
                                 ProjectEffects(gain_of_effects.middleCols(first_mounting_, size));
    effects->mountings_covariance += noise.AddedCovariance(gain);
  }

  bool HasNoiseBeyondModel() const { return check_.unmodelled && family_.of_boresight; }

  /// Returns the residuals of effects, one value per component of the score and column of X, as far
  /// as the unknowns do not follow them.
  Eigen::MatrixXd ProjectEffects(const Eigen::MatrixXd& X) const {
    return marginals_.Project(EffectRows(library_, linearized_, X));
  }

  /// Takes what the effects and the noise change in the figures of the whole adjustment.
  void TakeEffects(const NoiseRetest& retest) {
    check_.effects = selection_.effects;
    SetPriorSigmas(prior_, selection_.chosen, &check_.effects);
    check_.sigma0_with_effects =
        trajectory_.figures.sigma0 * retest.left().norm() / linearized_.residual().norm();
    for (std::size_t g = 0; g < forms_.channels; ++g) {
      GroupCheck& group = check_.groups[g];
      group.ratio_with_effects =
          forms_.all[g].Energy(retest.left()) / std::max(group.redundancy, 1e-12);
      if (!HasNoiseBeyondModel()) continue;
      group.explained = retest.Fits(g, group.redundancy, group.variance_ratio);
      group.covered =
          retest.Fits(g, group.redundancy, group.ratio_with_effects / kLargestVarianceRatio);
    }
  }

  /// Takes the noise beyond the stated one: from here on, the watched sigmas contain it.
  void TakeNoise(const UnmodelledUnknowns& unmodelled, const NoiseBeyondModel& noise) {
    if (!HasNoiseBeyondModel()) return;
    // The shift of the reported angles by a unit error of each row.
    const Eigen::MatrixXd gain = gain_ - ProjectEffects(unmodelled.Gain().leftCols(gain_.cols()));
    UnmodelledEffects& effects = *check_.unmodelled;
    const Eigen::Matrix3d added =
        noise.AddedCovariance(gain, network_.flight().config.lidar->sigma_p_m,
                              family_.watched_sigma, &effects.contributions);
    effects.covariance_rad2 += added;
    effects.noise_covariance_rad2 = added;
    TakeMountingNoise(noise, unmodelled.Gain(), &effects);
    family_.watched_sigma = (family_.watched_sigma.cwiseAbs2() + added.diagonal()).cwiseSqrt();
    std::stable_sort(effects.contributions.begin(), effects.contributions.end(),
                     [](const EffectContribution& a, const EffectContribution& b) {
                       return a.angle_sigma_rad.maxCoeff() > b.angle_sigma_rad.maxCoeff();
                     });
  }

  /// Returns the residuals if all discrepancies were estimated. The noise of the pairs must not
  /// contain what a discrepancy explains.
  Eigen::VectorXd ResidualWithDiscrepancies(const UnmodelledUnknowns& unmodelled) const {
    std::vector<Eigen::Index> components;
    for (const Hypothesis& hypothesis : library_.hypotheses) {
      if (hypothesis.id || library_.blocks[hypothesis.block].empty()) continue;
      const std::vector<Eigen::Index> own = hypothesis.Components(selection_.left);
      components.insert(components.end(), own.begin(), own.end());
    }
    Eigen::VectorXd found = selection_.joint;
    if (!components.empty()) {
      found(components) += TestJointly(selection_.left, components).estimate;
    }
    return ResidualWith(library_, marginals_, unmodelled.EstimateBeside(found) + found);
  }

  /// Returns the first rows of the watched rotations in the shift of a score.
  std::vector<Eigen::Index> AngleRows() const {
    std::vector<Eigen::Index> rows;
    const std::size_t step = family_.of_boresight ? 1 : 2;  // else rotation, position
    for (std::size_t k = 0; k < watched_.size(); k += step) {
      rows.push_back(3 * static_cast<Eigen::Index>(k));
    }
    return rows;
  }

  /// `score`: that of the model with the unmodelled effects.
  void FindEffects(const JointScore& score) {
    smallest_p_ = std::min(smallest_p_, SmallestEffectPValue(library_, score));
    check_.effective_tests += EffectiveTests(SmallestScorePValues(library_, score, kScoreDraws));
    selection_ = SelectByScores(library_, score, family_);
    check_.undetectable = FindUndetectable(library_, score, family_, prior_);
  }

  /// Returns the noise variance of the pairs, after the found effects, over the stated one; at
  /// least 1.
  double PairExcess() const {
    double ratio = 1.0;
    for (const GroupCheck& group : check_.groups) {
      if (group.name == "lidar p2p") ratio = std::max(ratio, group.ratio_with_effects);
    }
    return ratio;
  }

  void CheckAllDiscrepancies(const UnmodelledUnknowns& unmodelled) {
    double excess = PairExcess();
    if (check_.unmodelled && family_.of_boresight) {
      const NoiseBeyondModel noise =
          forms_.EstimateNoise(check_.groups, ResidualWithDiscrepancies(unmodelled));
      excess = std::max(excess, noise.PairGrowth());
    }
    check_.discrepancies = CheckDiscrepancies(library_, selection_.left, excess, family_);
    for (const DiscrepancyCheck& check : check_.discrepancies) {
      smallest_p_ = std::min(smallest_p_, ChiSquareTail(check.statistic, check.dof));
    }
  }

  void FindClocks(const JointScore& score) {
    check_.clocks = EstimateClocks(network_, marginals_, library_, score);
    if (!adjustment_.gnss_clock) return;
    const ClockEstimate& found = *adjustment_.gnss_clock;  // by the INS/GNSS solution
    check_.clocks.gnss = found;
    check_.gnss_clock_shift =
        family_.InSigmas(ShiftByGnssClock(found, library_, score, family_.watched_sigma.size()));
    const auto within = [&](EffectId effect, double value, double sigma) {
      const double prior = prior_.Sigma(effect)[0];
      return prior > 0.0 &&
             std::abs(value) <= EffectEvidence::kFaultPriorSigmas * std::hypot(prior, sigma);
    };
    check_.gnss_clock_within_prior =
        within(EffectId::kGnssTimeOffset, found.offset_s, found.sigma_offset_s) &&
        within(EffectId::kGnssTimeDrift, found.drift, found.sigma_drift);
  }

  void CheckPriors() {
    for (const LinearizedNetwork::FactorRows& rows : linearized_.factors()) {
      const bool is_prior = linearized_.group(rows.factor).kind == FactorGroup::Kind::kPrior;
      if (!is_prior || std::isfinite(linearized_.t_s(rows.factor))) continue;
      const BlockRecord& block =
          network_.net().block(network_.net().factor(rows.factor).blocks.front());
      const Prediction prediction = PredictFactor(marginals_, rows.factor);
      if (!prediction.determined) continue;
      const double p = ChiSquareTail(prediction.statistic, rows.count);
      check_.priors.push_back({block.name, prediction.statistic, rows.count, FamilyWise(p)});
    }
    check_.effective_tests += static_cast<double>(check_.priors.size());
  }

  const Adjustment& adjustment_;
  const FlightNetwork& network_;
  const Marginals& marginals_;
  const TrajectoryResult& trajectory_;
  const LinearizedNetwork& linearized_;
  UnmodelledPrior prior_;
  int threads_;
  TestedForms forms_;
  Library library_;
  std::optional<GnssProcessBasis> gnss_process_;
  std::optional<std::size_t> control_shift_;  // block of the library
  std::vector<BlockId> watched_;
  Eigen::Index first_mounting_ = 0;  // row of MountingUnknowns in the shift of a score
  TestFamily family_;
  Eigen::MatrixXd gain_;      // rows x watched coordinates
  double smallest_p_ = 1.0;   // of all tests, raw
  Eigen::VectorXd residual_;  // with the unmodelled effects
  ScoreSelection selection_;
  ModelCheck check_;
};

}  // namespace
}  // namespace diagnosis_internal

ModelCheck CheckModel(const Adjustment& adjustment, const Marginals& marginals,
                      const TrajectoryResult& trajectory, int threads) {
  ModelCheck check = diagnosis_internal::Checker(adjustment, marginals, trajectory, threads).Run();
  diagnosis_internal::AddFindings(adjustment, trajectory, &check);
  return check;
}

double ModelCheck::SmallestPValue() const {
  double smallest = 1.0;
  const auto note = [&](const auto& tests) {
    for (const auto& test : tests) smallest = std::min(smallest, test.p_value);
  };
  note(groups);
  note(common_errors);
  note(effects);
  note(discrepancies);
  note(priors);
  return smallest;
}

const char* Word(const ModelCheck& check) {
  return check.contradicted() ? Word(Verdict::kContradicted) : "consistent";
}

bool ModelCheck::contradicted() const {
  return std::any_of(findings.begin(), findings.end(),
                     [](const Finding& finding) { return finding.contradicts; });
}

}  // namespace dn
