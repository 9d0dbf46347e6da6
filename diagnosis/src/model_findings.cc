#include "model_findings.h"

#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "evidence.h"

namespace dn {
namespace diagnosis_internal {
namespace {

// The covariance of the boresight does not cover an error above this many of its sigmas.
constexpr double kMaxShiftInSigmas = 1.0;
// An effect beyond this many standard deviations of its prior is a fault, not a tolerance.
constexpr double kFaultPriorSigmas = 4.0;
constexpr double kLargestModelSigma0 = 3.0;
constexpr double kPairsLeftOut = 0.3;
constexpr double kGnssLeftOut = 0.1;
constexpr double kLargestBoresightDeg = 15.0;
constexpr double kUpsideDownShare = 0.9;
constexpr double kConclusive = std::numeric_limits<double>::infinity();

class Findings {
 public:
  explicit Findings(ModelCheck* check) : check_(*check) {}

  void Add(Fact fact, bool contradicts, double evidence) {
    check_.findings.push_back({std::move(fact), contradicts, evidence});
  }

  void Add(const std::vector<Finding>& findings) {
    check_.findings.insert(check_.findings.end(), findings.begin(), findings.end());
  }

  void JudgeGnssClock(const std::optional<ClockEstimate>& clock) {
    if (!clock) return;
    Add(facts::GnssTimeOff{*clock, check_.gnss_clock_shift, check_.of_boresight},
        check_.gnss_clock_shift > kMaxShiftInSigmas, kConclusive);
  }

  /// `told`: a finding already reports the GNSS clock.
  void JudgeEffects(bool told) {
    for (const EffectCheck& effect : check_.effects) {
      const bool of_clock = IsEffect(effect.name, EffectId::kGnssTimeOffset) ||
                            IsEffect(effect.name, EffectId::kGnssTimeDrift);
      if (told && of_clock) continue;
      const bool fault = effect.prior_sigmas ? *effect.prior_sigmas > kFaultPriorSigmas
                                             : effect.max_shift_sigmas > kMaxShiftInSigmas;
      Add(facts::EffectPresent{effect, check_.of_boresight}, fault, effect.log_evidence);
    }
  }

  void JudgeDiscrepancies() {
    for (const DiscrepancyCheck& discrepancy : check_.discrepancies) {
      if (discrepancy.p_value <= kFamilyLevel)
        Add(facts::UnmodelledDiscrepancy{discrepancy}, true, 0.0);
    }
  }

  void JudgeCompetingEffects() {
    for (const CompetingEffectCheck& competing : check_.competing_effects) {
      if (competing.max_shift_sigmas <= kMaxShiftInSigmas) continue;
      Add(facts::UnknownAmbiguous{competing, check_.of_boresight}, false, kConclusive);
    }
  }

  /// One wrong measurement bends the residuals of all others, so it comes before what these show.
  void JudgeIsolatedRows() {
    for (const GroupCheck& group : check_.groups) {
      if (group.isolated) Add(facts::VarianceTooLarge{group}, true, kConclusive);
    }
  }

  void JudgeGroups() {
    for (const GroupCheck& group : check_.groups) {
      if (group.isolated) continue;
      if (group.p_value > kFamilyLevel || group.variance_ratio < 1.0) continue;
      const bool contradicts = group.ratio_with_effects > kLargestVarianceRatio;
      Add(facts::VarianceTooLarge{group}, contradicts, 0.0);
    }
  }

  void JudgeCommonErrors() {
    for (const CommonErrorCheck& common : check_.common_errors) {
      if (common.p_value > kFamilyLevel || common.explained) continue;
      Add(facts::ErrorsShared{common}, common.max_shift_sigmas > kMaxShiftInSigmas,
          common.log_evidence);
    }
  }

  void JudgePriors() {
    for (const PriorCheck& prior : check_.priors) {
      if (prior.p_value <= kFamilyLevel) Add(facts::PriorContradicted{prior}, true, kConclusive);
    }
  }

  void JudgeVectors(const std::optional<PairData>& pairs) {
    if (!pairs) return;
    VectorOrigin weakest;
    std::vector<std::string> assumed;
    for (std::size_t k = 0; k < pairs->origins.size(); ++k) {
      if (pairs->origins[k].kind != VectorOrigin::Kind::kAssumed) continue;
      weakest = Weaker(weakest, pairs->origins[k]);
      assumed.push_back(pairs->files[k].filename().string());
    }
    if (assumed.empty()) return;
    std::string files = assumed.front();
    if (assumed.size() > 1) files += " and " + std::to_string(assumed.size() - 1) + " more";
    JudgeVectors(weakest, files);
  }

  void JudgeVectors(const VectorOrigin& origin, const std::string& files) {
    if (origin.kind != VectorOrigin::Kind::kAssumed) return;
    Add(facts::VectorsAssumed{origin.boresight_rad, files}, false, kConclusive);
  }

  void JudgeDiagnosis(const FlightConfig& config) {
    if (!config.unexplained.empty())
      Add(facts::GapUnexplained{config.unexplained}, true, kConclusive);
  }

  void JudgeMounting(const Eigen::Vector3d& angles_rad) {
    if (angles_rad.cwiseAbs().maxCoeff() * kDegPerRad <= kLargestBoresightDeg) return;
    Add(facts::MountingImpossible{angles_rad}, true, kConclusive);
  }

  void JudgeAttitude(const FlightNetwork& network) {
    double upside_down = 0.0;
    for (std::size_t k = 0; k < network.nodes().size(); ++k) {
      const Eigen::Quaterniond q_nb =
          ToNavPoint(network.trajectory().NodePose(k), network.flight().frame).q_nb;
      if (std::abs(RollPitchHeading(q_nb).x()) > 0.5 * std::numbers::pi) upside_down += 1.0;
    }
    if (upside_down < kUpsideDownShare * static_cast<double>(network.nodes().size())) return;
    Add(facts::UpsideDown{}, check_.of_boresight, kConclusive);
  }

  void JudgeSigma0(double sigma0) {
    if (sigma0 <= kLargestModelSigma0) return;
    // Effects that leave most of the misfit unexplained are not its cause.
    const bool unexplained = check_.sigma0_with_effects > 0.5 * sigma0;
    Add(facts::Sigma0TooLarge{sigma0}, true, unexplained ? kConclusive : 0.0);
  }

  void JudgePairsLeftOut(long left_out, long pairs) {
    const double share = static_cast<double>(left_out) / std::max(1.0, static_cast<double>(pairs));
    if (share > kPairsLeftOut) Add(facts::PairsLeftOut{share}, true, 0.0);
  }

  void JudgeGnssLeftOut(long left_out, long epochs) {
    const double share = static_cast<double>(left_out) / std::max(1.0, static_cast<double>(epochs));
    if (share > kGnssLeftOut) Add(facts::GnssLeftOut{share}, true, 0.0);
  }

  void Sort() {
    std::stable_sort(check_.findings.begin(), check_.findings.end(),
                     [](const Finding& a, const Finding& b) {
                       if (a.contradicts != b.contradicts) return a.contradicts;
                       return a.evidence > b.evidence;
                     });
  }

 private:
  ModelCheck& check_;
};

}  // namespace

void AddFindings(const Adjustment& adjustment, const TrajectoryResult& trajectory,
                 ModelCheck* check) {
  const FlightNetwork& network = *adjustment.network;
  Findings findings(check);
  findings.JudgeIsolatedRows();
  findings.JudgeDiagnosis(network.flight().config);
  findings.JudgePriors();
  if (check->of_boresight) findings.JudgeVectors(network.flight().pairs);
  if (check->of_boresight)
    findings.JudgeMounting(Log(network.net().Value(network.calibration().boresight())));
  findings.JudgeAttitude(network);
  findings.JudgeGnssClock(adjustment.gnss_clock);
  findings.JudgeEffects(adjustment.gnss_clock.has_value());
  findings.JudgeDiscrepancies();
  findings.JudgeCompetingEffects();
  findings.JudgeCommonErrors();
  findings.JudgeSigma0(trajectory.figures.sigma0);
  findings.JudgePairsLeftOut(adjustment.outliers,
                             static_cast<long>(network.pairs().edges().size()));
  findings.JudgeGnssLeftOut(static_cast<long>(adjustment.gnss_rejected.size()),
                            static_cast<long>(network.gnss().edges().size()));
  findings.JudgeGroups();
  findings.Add(adjustment.warnings);
  findings.Sort();
}

void AddFindings(const Flight& flight, const GaussHelmertCalibration& calibration,
                 ModelCheck* check) {
  Findings findings(check);
  findings.JudgeDiagnosis(flight.config);
  findings.JudgeVectors(flight.pairs);
  findings.JudgePriors();
  findings.JudgeMounting(calibration.boresight.angles_rad);
  findings.JudgeEffects(false);
  findings.JudgeDiscrepancies();
  findings.JudgeSigma0(calibration.figures.sigma0 / std::sqrt(calibration.scatter.expected_ratio));
  findings.JudgePairsLeftOut(calibration.adjustment.outliers,
                             static_cast<long>(calibration.adjustment.weights.size()));
  findings.JudgeGroups();
  findings.Sort();
}

void AddFindings(const Flight& flight, const PlaneCalibration& calibration, ModelCheck* check) {
  Findings findings(check);
  findings.JudgeDiagnosis(flight.config);
  findings.JudgeVectors(calibration.origin, "");
  findings.JudgeMounting(calibration.boresight.angles_rad);
  findings.JudgeSigma0(check->sigma0_with_effects);
  findings.JudgeGroups();
  findings.Sort();
}

}  // namespace diagnosis_internal

namespace {

template <class T>
bool Holds(const ModelCheck& check) {
  return std::any_of(check.findings.begin(), check.findings.end(),
                     [](const Finding& finding) { return finding.As<T>() != nullptr; });
}

}  // namespace

void AddUnmodelled(const UnmodelledEffects& effects, BoresightResult* boresight) {
  boresight->as_modelled = {boresight->angles_rad, boresight->covariance_rad2};
  const Eigen::Quaterniond q = Exp(effects.boresight_rad) * Exp(boresight->angles_rad);
  boresight->angles_rad = Log(q);
  boresight->euler_zyx_rad = RollPitchHeading(q);
  boresight->covariance_rad2 += effects.covariance_rad2;
  boresight->contributions = effects.contributions;
  if (boresight->verdict == Verdict::kCalibrated) {
    AssessLargestSigma(boresight->sigma_rad(), boresight);
  }
}

void Assess(const ModelCheck& check, BoresightResult* boresight) {
  if (check.unmodelled) AddUnmodelled(*check.unmodelled, boresight);
  if (Holds<facts::VectorsAssumed>(check) && boresight->verdict == Verdict::kCalibrated) {
    boresight->verdict = Verdict::kAbsorbed;
  }
  if (Holds<facts::UnknownAmbiguous>(check) && check.of_boresight) {
    boresight->verdict = Verdict::kNotObservable;
  }
  if (check.contradicted()) boresight->verdict = Verdict::kContradicted;
  std::vector<Finding> reasons = check.findings;
  for (const Finding& reason : boresight->reasons) {
    const bool told = std::any_of(
        check.findings.begin(), check.findings.end(),
        [&](const Finding& finding) { return finding.fact.index() == reason.fact.index(); });
    if (!told) reasons.push_back(reason);
  }
  boresight->reasons = std::move(reasons);
}

}  // namespace dn
