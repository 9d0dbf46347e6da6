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
#include "finding_causes.h"

namespace dn {
namespace diagnosis_internal {
namespace {

constexpr double kLargestModelSigma0 = 3.0;
constexpr double kPairsLeftOut = 0.3;
constexpr double kGnssLeftOut = 0.1;
constexpr double kLargestBoresightDeg = 15.0;
constexpr double kUpsideDownShare = 0.9;
constexpr double kConclusive = std::numeric_limits<double>::infinity();

void Add(Fact fact, bool contradicts, double evidence, ModelCheck* check) {
  check->findings.push_back({std::move(fact), contradicts, evidence});
}

/// Returns whether a finding reports the GNSS clock.
bool JudgeGnssClock(const std::optional<ClockEstimate>& clock, ModelCheck* check) {
  if (!clock || !(clock->shows_offset() || clock->shows_drift())) return false;
  Add(facts::GnssTimeOff{*clock, check->gnss_clock_shift, check->of_boresight},
      check->gnss_clock_shift > kMaxShiftInSigmas && !check->gnss_clock_within_prior, kConclusive,
      check);
  return true;
}

/// `told`: a finding already reports the GNSS clock.
void JudgeEffects(bool told, ModelCheck* check) {
  for (const EffectCheck& effect : check->effects) {
    const bool of_clock = IsEffect(effect.name, EffectId::kGnssTimeOffset) ||
                          IsEffect(effect.name, EffectId::kGnssTimeDrift);
    if (told && of_clock) continue;
    const bool fault =
        effect.prior_sigmas ? !effect.within_prior() : effect.max_shift_sigmas > kMaxShiftInSigmas;
    Add(facts::EffectPresent{effect, check->of_boresight}, fault, effect.log_evidence, check);
  }
}

void JudgeDiscrepancies(ModelCheck* check) {
  for (const DiscrepancyCheck& discrepancy : check->discrepancies) {
    if (discrepancy.p_value <= kFamilyLevel)
      Add(facts::UnmodelledDiscrepancy{discrepancy}, true, 0.0, check);
  }
}

void JudgeCompetingEffects(ModelCheck* check) {
  for (const CompetingEffectCheck& competing : check->competing_effects) {
    if (competing.max_shift_sigmas <= kMaxShiftInSigmas) continue;
    Add(facts::UnknownAmbiguous{competing, check->of_boresight}, false, kConclusive, check);
  }
}

/// One wrong measurement bends the residuals of all others, so it comes before what these show.
void JudgeIsolatedRows(ModelCheck* check) {
  for (const GroupCheck& group : check->groups) {
    if (group.isolated) Add(facts::VarianceTooLarge{group}, true, kConclusive, check);
  }
}

void JudgeGroups(ModelCheck* check) {
  for (const GroupCheck& group : check->groups) {
    if (group.isolated) continue;
    if (group.p_value > kFamilyLevel || group.variance_ratio < 1.0 || group.explained) continue;
    const bool contradicts = group.ratio_with_effects > kLargestVarianceRatio && !group.covered;
    Add(facts::VarianceTooLarge{group}, contradicts, 0.0, check);
  }
}

void JudgeCommonErrors(ModelCheck* check) {
  for (const CommonErrorCheck& common : check->common_errors) {
    if (common.p_value > kFamilyLevel || common.explained) continue;
    Add(facts::ErrorsShared{common}, common.max_shift_sigmas > kMaxShiftInSigmas && !common.covered,
        common.log_evidence, check);
  }
}

void JudgePriors(ModelCheck* check) {
  for (const PriorCheck& prior : check->priors) {
    if (prior.p_value <= kFamilyLevel)
      Add(facts::PriorContradicted{prior}, true, kConclusive, check);
  }
}

void JudgeVectors(const VectorOrigin& origin, const std::string& files, ModelCheck* check) {
  if (origin.kind != VectorOrigin::Kind::kAssumed) return;
  Add(facts::VectorsAssumed{origin.boresight_rad, files}, false, kConclusive, check);
}

void JudgeVectors(const std::optional<PairData>& pairs, ModelCheck* check) {
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
  JudgeVectors(weakest, files, check);
}

void JudgeDiagnosis(const FlightConfig& config, ModelCheck* check) {
  if (!config.unexplained.empty())
    Add(facts::GapUnexplained{config.unexplained}, true, kConclusive, check);
}

void JudgeMounting(const Eigen::Vector3d& angles_rad, ModelCheck* check) {
  if (angles_rad.cwiseAbs().maxCoeff() * kDegPerRad <= kLargestBoresightDeg) return;
  Add(facts::MountingImpossible{angles_rad}, true, kConclusive, check);
}

void JudgeAttitude(const FlightNetwork& network, ModelCheck* check) {
  double upside_down = 0.0;
  for (std::size_t k = 0; k < network.nodes().size(); ++k) {
    const Eigen::Quaterniond q_nb =
        ToNavPoint(network.trajectory().NodePose(k), network.flight().frame).q_nb;
    if (std::abs(RollPitchHeading(q_nb).x()) > 0.5 * std::numbers::pi) upside_down += 1.0;
  }
  if (upside_down < kUpsideDownShare * static_cast<double>(network.nodes().size())) return;
  Add(facts::UpsideDown{}, check->of_boresight, kConclusive, check);
}

void JudgeSigma0(double sigma0, ModelCheck* check) {
  if (sigma0 <= kLargestModelSigma0) return;
  // Effects that leave most of the misfit unexplained are not its cause.
  const bool unexplained = check->sigma0_with_effects > 0.5 * sigma0;
  Add(facts::Sigma0TooLarge{sigma0}, true, unexplained ? kConclusive : 0.0, check);
}

void JudgePairsLeftOut(long left_out, long pairs, ModelCheck* check) {
  const double share = static_cast<double>(left_out) / std::max(1.0, static_cast<double>(pairs));
  if (share > kPairsLeftOut) Add(facts::PairsLeftOut{share}, true, 0.0, check);
}

void JudgeGnssLeftOut(long left_out, long epochs, ModelCheck* check) {
  const double share = static_cast<double>(left_out) / std::max(1.0, static_cast<double>(epochs));
  if (share > kGnssLeftOut) Add(facts::GnssLeftOut{share}, true, 0.0, check);
}

void JudgeGnssRuns(ModelCheck* check) {
  for (const GnssRunCheck& run : check->gnss_runs) {
    if (run.is_gnss()) continue;
    Add(facts::GnssRunDoubtful{run, check->of_boresight},
        run.is_inertial() || run.max_shift_sigmas > kMaxShiftInSigmas, 0.0, check);
  }
}

void JudgeControl(ModelCheck* check) {
  constexpr double kControlLeftOut = 1.0 / 3.0;
  if (!check->control) return;
  const auto& shift = check->control->shift;
  const bool shifted = shift && shift->p_value <= kFamilyLevel;
  long observations = 0, rejected = 0;
  for (const ControlPointCheck& point : check->control->points) {
    if (point.role != ControlPointCheck::Role::kCheck) ++observations;
    if (point.role == ControlPointCheck::Role::kRejected) ++rejected;
    if (point.role == ControlPointCheck::Role::kRejected ||
        (!shifted && point.p_value <= kFamilyLevel)) {
      Add(facts::ControlPointWrong{point}, false, kConclusive, check);
    }
  }
  if (shifted) {
    Add(facts::ControlShifted{*shift}, true, kConclusive, check);
  }
  if (static_cast<double>(rejected) > kControlLeftOut * static_cast<double>(observations)) {
    Add(facts::ControlLeftOut{rejected, observations}, true, kConclusive, check);
  }
}

void Sort(ModelCheck* check) {
  std::stable_sort(check->findings.begin(), check->findings.end(),
                   [](const Finding& a, const Finding& b) {
                     if (a.contradicts != b.contradicts) return a.contradicts;
                     return a.evidence > b.evidence;
                   });
  SortByCause(&check->findings);
}

/// Judges an adjustment on a fixed trajectory. `sigma0` is relative to its expectation under the
/// stated, time-correlated errors of the trajectory.
void JudgeFixedTrajectory(const Flight& flight, const BoresightResult& boresight, double sigma0,
                          ModelCheck* check) {
  JudgeDiagnosis(flight.config, check);
  JudgePriors(check);
  JudgeMounting(boresight.angles_rad, check);
  JudgeEffects(false, check);
  JudgeDiscrepancies(check);
  JudgeSigma0(sigma0, check);
}

/// Adds the warnings of the INS/GNSS stage, which knows the pure model only. A lever arm that seems
/// to be off there does not contradict if no GNSS effect is left beyond its prior.
void AddWarnings(const std::vector<Finding>& warnings, ModelCheck* check) {
  const bool left = std::any_of(check->effects.begin(), check->effects.end(), [](const auto& one) {
    return FindEffect(one.name)->sensor == EffectSensor::kGnss;
  });
  for (Finding warning : warnings) {
    if (check->unmodelled && !left && warning.As<facts::GnssLeverArmOff>() != nullptr) {
      warning.contradicts = false;
    }
    check->findings.push_back(std::move(warning));
  }
}

}  // namespace

void AddFindings(const Adjustment& adjustment, const TrajectoryResult& trajectory,
                 ModelCheck* check) {
  const FlightNetwork& network = *adjustment.network;
  JudgeIsolatedRows(check);
  JudgeDiagnosis(network.flight().config, check);
  JudgePriors(check);
  if (check->of_boresight) {
    JudgeVectors(network.flight().pairs, check);
    JudgeMounting(Log(network.net().Value(network.calibration().boresight())), check);
  }
  JudgeAttitude(network, check);
  const bool clock_told = JudgeGnssClock(adjustment.gnss_clock, check);
  JudgeEffects(clock_told, check);
  JudgeDiscrepancies(check);
  JudgeCompetingEffects(check);
  JudgeCommonErrors(check);
  JudgeSigma0(trajectory.figures.sigma0, check);
  JudgePairsLeftOut(adjustment.outliers, static_cast<long>(network.pairs().edges().size()), check);
  JudgeGnssLeftOut(static_cast<long>(adjustment.gnss_rejected.size()),
                   static_cast<long>(network.gnss().edges().size()), check);
  JudgeGnssRuns(check);
  JudgeGroups(check);
  JudgeControl(check);
  AddWarnings(adjustment.warnings, check);
  Sort(check);
}

void AddFindings(const Flight& flight, const GaussHelmertCalibration& calibration,
                 ModelCheck* check) {
  JudgeVectors(flight.pairs, check);
  JudgeFixedTrajectory(flight, calibration.boresight,
                       calibration.figures.sigma0 / std::sqrt(calibration.scatter.expected_ratio),
                       check);
  JudgePairsLeftOut(calibration.adjustment.outliers,
                    static_cast<long>(calibration.adjustment.weights.size()), check);
  JudgeGroups(check);
  Sort(check);
}

void AddFindings(const Flight& flight, const PlaneCalibration& calibration, ModelCheck* check) {
  JudgeVectors(calibration.origin, "", check);
  JudgeFixedTrajectory(flight, calibration.boresight, check->sigma0_with_effects, check);
  JudgeGroups(check);
  Sort(check);
}

}  // namespace diagnosis_internal

namespace {

template <class T>
bool Holds(const ModelCheck& check) {
  return std::any_of(check.findings.begin(), check.findings.end(),
                     [](const Finding& finding) { return finding.As<T>() != nullptr; });
}

/// Returns whether all reasons are lever arms that the check found within their prior.
bool OnlyTolerated(const BoresightResult& boresight, const ModelCheck& check) {
  return !check.contradicted() &&
         std::all_of(boresight.reasons.begin(), boresight.reasons.end(), [](const Finding& reason) {
           return reason.As<facts::GnssLeverArmOff>() != nullptr;
         });
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
  AddFindings(check, boresight);
}

void AddFindings(const ModelCheck& check, BoresightResult* boresight) {
  if (boresight->verdict == Verdict::kAbsorbed && check.unmodelled &&
      OnlyTolerated(*boresight, check)) {
    boresight->verdict = Verdict::kCalibrated;
  }
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
    const bool refuted = check.contradicted() && reason.As<facts::TrajectoryEstimated>() != nullptr;
    if (!told && !refuted) reasons.push_back(reason);
  }
  boresight->reasons = std::move(reasons);
}

}  // namespace dn
