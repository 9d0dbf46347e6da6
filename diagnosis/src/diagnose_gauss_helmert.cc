#include "diagnose_gauss_helmert.h"

#include <dn/adjustment/gauss_helmert_flight.h>
#include <dn/diagnosis/adapt.h>
#include <dn/diagnosis/report.h>
#include <dn/effects/effect_table.h>
#include <dn/interrupted.h>
#include <dn/log_sum.h>
#include <dn/rotation.h>
#include <dn/sim/random.h>
#include <dn/symmetric_eigen.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "decision.h"
#include "gauss_helmert_evidence.h"
#include "hidden_effects.h"
#include "lap_times.h"
#include "outlier_evidence.h"
#include "slots.h"
#include "twins.h"
#include "unavailable.h"

namespace dn::internal {
namespace {

constexpr std::size_t kFewestPairsOfFlight = 100;
// Evidence that larger trajectory errors must have. Good flights reach up to about half of it,
// because the model of the trajectory errors is not complete.
constexpr double kLargerErrorsNats = 20.0;
// Norm of a standardised misclosure that counts as an outlier, and the fraction of good pairs above
// it.
constexpr double kOutlierPairNorm = 4.6, kGoodPairsLost = 2e-4;

/// The pairs compared with their replicates, with the selected effects among the unknowns.
struct ComparedPairs {
  ResidualSummary appearance;
  ReplicateSet twins;
  ReplicateTest test;
};

class GaussHelmertDiagnosis {
 public:
  GaussHelmertDiagnosis(const Flight& flight, const GapOptions& options,
                        GaussHelmertCalibration calibration)
      : flight_(flight),
        options_(options),
        calibration_(std::move(calibration)),
        strips_(FindStrips(flight)),
        pairs_(LinearisePairs(flight, calibration_)),
        library_(MakeLibrary(flight, pairs_, strips_,
                             {options.effects, options.left_out, options.threads})),
        evidence_(library_, pairs_, strips_, WithNoiseScale()),
        watch_(&out_.timings_s) {
    out_.flight = flight.config.name;
    out_.trajectory_given = true;
    out_.validity.alpha = options.alpha;
  }

  /// Computes the detection limits for trajectory errors of the stated size, without the
  /// misclosures.
  GapResult Limits() {
    Report("limits", 0.2);
    base_ = Explain({});
    base_.screen = std::move(base_.with_stated_errors);
    FillDetectionLimits(kDesignThresholdNats);
    watch_.Lap("limits");
    return WithLimits(flight_, std::move(out_));
  }

  GapResult Run() {
    Report("effects with trajectory errors", 0.2);
    base_ = Explain({});
    watch_.Lap("screen");
    Report("replicates", 0.5);
    before_ = Compare(base_);
    watch_.Lap("twins");
    JudgeGap();
    if (out_.detected) SelectEffects();
    MakeAllHypotheses();
    watch_.Lap("attribution");
    FillWhere();
    FillCauses(base_.others, slots_, NamedCauses(), &out_);
    if (!chosen_.empty()) after_ = Compare(final_);
    FillVerdict();
    if (!chosen_.empty()) MeasureShrinkage();
    Report("limits", 0.9);
    FillDetectionLimits(Threshold());
    watch_.Lap("limits");
    FillNotes();
    out_.verdict.text = VerdictSentence(out_);
    return Result();
  }

 private:
  void Report(const std::string& stage, double fraction) const {
    if (options_.interrupted && options_.interrupted()) throw Interrupted();
    if (options_.progress) options_.progress(stage, fraction);
  }

  bool Wanted(EffectId effect) const {
    return LibraryOptions{options_.effects, options_.left_out, 1}.Wanted(effect);
  }

  /// Returns whether the noise of the pairs is screened. A robust loss also reduces the weight of
  /// good pairs, and with it their apparent noise.
  bool WithNoiseScale() const {
    return flight_.config.lidar->robust == RobustKind::kNone && Wanted(EffectId::kP2pNoiseScale);
  }

  ExtendedPairFit Explain(const std::vector<ScreenedEffect>& chosen) {
    ExtendedPairFit explained = evidence_.Explain(chosen);
    const bool there = std::any_of(chosen.begin(), chosen.end(), [](const auto& effect) {
      return effect.id == EffectId::kP2pOutliers;
    });
    if (!there && Wanted(EffectId::kP2pOutliers)) AddOutliers(explained.scale, &explained.others);
    return explained;
  }

  /// Converts a scale relative to the smoother's accuracy to one relative to the sigmas at the ends
  /// of the pairs. These sigmas come from the section `trajectory`.
  ErrorScale ScaleAtPairEnds(const ErrorScale& scale) const {
    const GaussHelmertEnd& end = calibration_.problem.pairs.front().i;
    const TrajectoryAccuracy& accuracy = calibration_.accuracy;
    return {scale.position * accuracy.sigma_ned_m.norm() / end.sigma_ned_m.norm(),
            scale.attitude * accuracy.sigma_rph_rad.norm() / end.sigma_rph_rad.norm()};
  }

  /// Adds the effect of outliers: the rejected pairs that trajectory errors do not explain.
  void AddOutliers(const ErrorScale& scale, std::vector<ScreenedEffect>* effects) {
    const GaussHelmertProblem& problem = calibration_.problem;
    std::vector<double> lengths_m;
    outliers_ = 0;
    for (std::size_t k = 0; k < problem.pairs.size(); ++k) {
      if (calibration_.adjustment.weights[k] > 0.0) continue;
      const PairLinearisation at =
          LinearisePair(problem.pairs[k], problem.lever_arm_b_m, calibration_.options.model,
                        calibration_.adjustment.boresight_rad, PairCorrection::Zero());
      const Eigen::Matrix3d covariance =
          MisclosureCovariance(problem.pairs[k], at, ScaleAtPairEnds(scale));
      if (at.w.dot(covariance.llt().solve(at.w)) < kOutlierPairNorm * kOutlierPairNorm) continue;
      ++outliers_;
      lengths_m.push_back(at.w.norm());
    }
    const ScreenedEffect outliers =
        OutlierEffect(EffectId::kP2pOutliers, outliers_, static_cast<long>(problem.pairs.size()),
                      kGoodPairsLost, lengths_m);
    const auto at = std::find_if(effects->begin(), effects->end(), [&](const auto& effect) {
      return effect.log_evidence < outliers.log_evidence;
    });
    effects->insert(at, outliers);
  }

  // ---- Replicates -------------------------------------------------------------------------------

  /// Returns the misclosures summed over each place, in units of their sigma.
  Eigen::VectorXd Places(const JointScore& score, const Eigen::VectorXd& s) const {
    std::vector<double> z;
    for (const PairPlace& place : library_.places) {
      for (Eigen::Index c = score.first[place.block]; c < score.first[place.block + 1]; ++c) {
        const bool absorbed = score.A(c, c) < 1e-7 * score.signature2[c];
        z.push_back(absorbed ? 0.0 : s[c] / std::sqrt(score.A(c, c)));
      }
    }
    return Eigen::VectorXd::Map(z.data(), static_cast<Eigen::Index>(z.size()));
  }

  /// `gross`: excess of the number of outliers over the number expected from good pairs, in sigmas.
  ResidualSummary SummariseScores(const Screen& screen, const Eigen::VectorXd& s, double chi2,
                                  double white, double gross) const {
    const double n = evidence_.observations();
    ResidualSummary appearance;
    const Eigen::VectorXd places = Places(screen.score(), s);
    appearance.locations.resize(places.size() + 2);
    appearance.locations << places, (chi2 - n) / std::sqrt(2.0 * n), gross;
    appearance.log_evidence.resize(static_cast<Eigen::Index>(screen.families().size()) + 1);
    for (std::size_t k = 0; k < screen.families().size(); ++k) {
      appearance.log_evidence[static_cast<Eigen::Index>(k)] =
          screen.LogEvidence(screen.families()[k], s);
    }
    appearance.log_evidence.tail<1>()[0] = evidence_.NoiseEvidence(chi2);
    appearance.size_nats = std::max(0.0, appearance.log_evidence.maxCoeff()) / n;
    appearance.pair_rms_m = PairSigma() * std::sqrt(chi2 / n) * white / evidence_.min_white();
    return appearance;
  }

  double PairSigma() const {
    double sum = 0.0;
    for (const std::size_t k : pairs_.pair) {
      sum += calibration_.problem.pairs[k].covariance_m2.trace() / 3.0;
    }
    return std::sqrt(sum / static_cast<double>(pairs_.pair.size()));
  }

  /// Compares the scores with replicates that have the covariance of a flight without any effect.
  ComparedPairs Compare(const ExtendedPairFit& explained) const {
    return Compare(*explained.screen, explained.chi2, explained.scale.white,
                   OutlierExcessInSigmas(explained));
  }

  ComparedPairs Compare(const Screen& screen, double chi2_of_pairs, double white,
                        double gross) const {
    const JointScore& score = screen.score();
    const SymmetricEigen eigen(score.A);
    const Eigen::MatrixXd root =
        eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
    ComparedPairs out;
    for (int twin = 0; twin < NumReplicates(options_.depth); ++twin) {
      if (options_.interrupted && options_.interrupted()) throw Interrupted();
      Random random(options_.seed, "twin/" + std::to_string(twin));
      Eigen::VectorXd noise(root.cols());
      for (Eigen::Index k = 0; k < noise.size(); ++k) noise[k] = random.Normal();
      const double n = evidence_.observations();
      const double chi2 = std::max(0.0, n + std::sqrt(2.0 * n) * random.Normal());
      out.twins.all.push_back(SummariseScores(screen, root * noise, chi2, white, random.Normal()));
    }
    out.appearance = SummariseScores(screen, score.s, chi2_of_pairs, white, gross);
    out.test = CompareWithReplicates(out.appearance, out.twins);
    return out;
  }

  /// Returns the excess number of outliers in sigmas. The root of a count has a constant variance
  /// (Anscombe).
  double OutlierExcessInSigmas(const ExtendedPairFit& explained) const {
    for (const ScreenedEffect& effect : explained.chosen) {
      if (effect.id == EffectId::kP2pOutliers) return 0.0;
    }
    const double typical = kGoodPairsLost * static_cast<double>(calibration_.problem.pairs.size());
    const double more =
        2.0 * (std::sqrt(static_cast<double>(outliers_) + 0.375) - std::sqrt(typical + 0.375));
    return std::max(0.0, more);
  }

  double Threshold() const { return ThresholdNats(before_.test.evidence_95); }

  // ---- Is there a gap, and where ----------------------------------------------------------------

  /// Returns a p-value. The mean likelihood ratio of the family exceeds 1 / p with probability p at
  /// most.
  static double PByEvidence(const std::vector<ScreenedEffect>& effects) {
    LogSum sum;
    for (const ScreenedEffect& effect : effects) sum.Add(effect.log_evidence);
    return std::min(1.0, static_cast<double>(effects.size()) * std::exp(-sum.Value()));
  }

  /// Returns the p-value from the evidence alone. Replicates at one scale of the trajectory errors
  /// do not show that this scale was itself estimated.
  static double PValue(const ExtendedPairFit& explained) {
    const bool larger = explained.larger_errors_nats > kLargerErrorsNats;
    return std::min(PByEvidence(explained.others),
                    larger ? std::exp(-explained.larger_errors_nats) : 1.0);
  }

  void JudgeGap() {
    out_.p_value = PValue(base_);
    out_.detected = out_.p_value <= options_.alpha;
    out_.validity.observations = static_cast<long>(evidence_.observations());
    out_.validity.twins = static_cast<int>(before_.twins.all.size());
    out_.validity.tests =
        static_cast<int>(before_.test.z.size()) + static_cast<int>(base_.others.size());
    FillSize();
  }

  static std::vector<double> ReplicateSizes(const ComparedPairs& compared) {
    std::vector<double> sizes;
    for (const ResidualSummary& twin : compared.twins.all) sizes.push_back(twin.size_nats);
    std::sort(sizes.begin(), sizes.end());
    return sizes;
  }

  void FillSize() {
    const std::vector<double> sizes = ReplicateSizes(before_);
    const auto at = [&](double p) {
      return sizes[static_cast<std::size_t>(p * static_cast<double>(sizes.size() - 1))];
    };
    out_.size.value = LeftNats(base_) / evidence_.observations();
    out_.size.null_low = at(0.025);
    out_.size.null_high = at(0.975);
    out_.size.upper_limit_95 = std::max(0.0, out_.size.value - at(0.05)) + at(0.95);
    const double n = evidence_.observations();
    out_.user_units.p2p_excess_m =
        before_.appearance.pair_rms_m * std::sqrt(std::max(0.0, 1.0 - n / std::max(n, base_.chi2)));
  }

  /// Returns the quantity and the location of a statistic of SummariseScores.
  std::pair<std::string, std::string> StatisticLabel(Eigen::Index statistic) const {
    const char* axes[] = {"east", "north", "up"};
    const auto place = static_cast<std::size_t>(statistic / 3);
    if (place < library_.places.size()) {
      return {std::string("p2p ") + axes[statistic % 3], library_.places[place].location};
    }
    const bool square = statistic % 3 == 0;
    return {square ? "p2p, mean square" : "p2p, outliers", "the whole flight"};
  }

  void FillWhere() {
    const ComparedPairs stated = Compare(*base_.with_stated_errors, base_.chi2_with_stated_errors,
                                         base_.scale.white, OutlierExcessInSigmas(base_));
    const ReplicateTest& test = stated.test;
    const double larger_nats = (chosen_.empty() ? base_ : final_).larger_errors_nats;
    if (larger_nats > kLargerErrorsNats) {
      out_.where.push_back({"trajectory", "time-correlated errors larger than stated",
                            "the whole flight", larger_nats, std::exp(-larger_nats)});
    }
    for (const Eigen::Index k : test.LargestFirst()) {
      const auto [quantity, place] = StatisticLabel(k);
      out_.fingerprint.push_back({fmt::format("lidar {}, {}", quantity, place),
                                  stated.appearance.locations[k], test.mean[k], test.sigma[k],
                                  std::nullopt, std::nullopt});
      if (out_.where.size() >= kMaxPlaces || test.p_adjusted[k] > options_.alpha) continue;
      if (!out_.detected) continue;
      out_.where.push_back({"lidar", quantity, place, test.z[k], test.p_adjusted[k]});
    }
  }

  // ---- Why --------------------------------------------------------------------------------------

  void SelectEffects() {
    final_ = Explain({});
    while (chosen_.size() < kMaxCauses) {
      const ScreenedEffect* best = BestPhysical(final_.others);
      if (best == nullptr || best->log_evidence < Threshold()) break;
      Report("with " + best->name, 0.6);
      chosen_.push_back(*best);
      explained_nats_ += best->log_evidence;
      final_ = Explain(chosen_);
    }
    Revise();
  }

  void MakeAllHypotheses() {
    if (chosen_.empty()) slots_.push_back(MakeCompetingHypotheses("", base_.others));
    for (std::size_t k = 0; k < chosen_.size(); ++k) {
      slots_.push_back(MakeCompetingHypotheses(chosen_[k].name, Explain(Without(k)).others));
    }
  }

  std::vector<ScreenedEffect> Without(std::size_t k) const {
    std::vector<ScreenedEffect> others = chosen_;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    return others;
  }

  /// Revises at most one earlier choice: each was made with fewer effects in the model than now.
  void Revise() {
    for (std::size_t k = 0; k + 1 < chosen_.size(); ++k) {
      const ExtendedPairFit others = Explain(Without(k));
      const ScreenedEffect* best = BestPhysical(others.others);
      const double own = FindEvidence(others.others, chosen_[k].name);
      if (best == nullptr || best->log_evidence < Threshold()) {
        chosen_ = Without(k);
      } else if (best->log_evidence > own + kReplacementLeadNats) {
        const ScreenedEffect better = *best;
        chosen_ = Without(k);
        chosen_.push_back(better);
      } else {
        continue;
      }
      final_ = Explain(chosen_);
      return;
    }
  }

  void FillVerdict() {
    std::vector<std::string> named;
    for (const ScreenedEffect& effect : chosen_) named.push_back(effect.name);
    const Decision decision{
        out_.detected, DiscrepancyEvidence(base_.others) > explained_nats_ + kDiscrepancyLeadNats,
        !chosen_.empty() && PValue(final_) <= options_.alpha};
    out_.verdict = Decide(decision, named, slots_);
    ScaleToObservedRates(out_.verdict, &out_.causes);
  }

  std::vector<GapCause> NamedCauses() const {
    std::vector<GapCause> named;
    if (chosen_.empty()) return named;
    for (const ScreenedEffect& effect : final_.chosen) named.push_back(ToCause(effect));
    return named;
  }

  /// Returns the evidence of the best explanation that was not selected.
  static double LeftNats(const ExtendedPairFit& explained) {
    const double most =
        explained.others.empty() ? 0.0 : std::max(0.0, explained.others.front().log_evidence);
    return most + std::max(0.0, explained.larger_errors_nats);
  }

  /// Returns the reduction of LeftNats beyond its mean over replicates.
  GapShrinkage Closed() const {
    const std::vector<double> sizes = ReplicateSizes(after_);
    double typical = 0.0;
    for (const double size : sizes) typical += size / static_cast<double>(sizes.size());
    const double n = evidence_.observations();
    const double excess = std::max(LeftNats(base_) - n * typical, 1.0);
    const double left = LeftNats(final_) - n * typical;
    const auto closed = [&](double p) {
      const double size =
          sizes[static_cast<std::size_t>(p * static_cast<double>(sizes.size() - 1))];
      return 1.0 - std::max(0.0, left - n * (size - typical)) / excess;
    };
    GapShrinkage shrinkage;
    shrinkage.fraction = 1.0 - std::max(0.0, left) / excess;
    shrinkage.interval_low = closed(0.025);
    shrinkage.interval_high = closed(0.975);
    return shrinkage;
  }

  void MeasureShrinkage() {
    if (out_.verdict.effects.empty()) return;
    GapShrinkage shrinkage = Closed();
    shrinkage.before.p_value = out_.p_value;
    shrinkage.before.size_nats_per_obs = out_.size.value;
    shrinkage.before.p2p_m = before_.appearance.pair_rms_m;
    shrinkage.after.p_value = PValue(final_);
    shrinkage.after.size_nats_per_obs = LeftNats(final_) / evidence_.observations();
    shrinkage.after.p2p_m = after_.appearance.pair_rms_m;
    const BoresightResult& boresight = calibration_.boresight;
    shrinkage.before.boresight_rad = boresight.angles_rad;
    shrinkage.before.boresight_sigma_rad = boresight.sigma_rad();
    shrinkage.after.boresight_rad = BoresightAfter();
    const Eigen::Matrix3d covariance = boresight.covariance_rad2 + final_.boresight_covariance_rad2;
    shrinkage.after.boresight_sigma_rad = covariance.diagonal().cwiseSqrt();
    out_.shrinkage = shrinkage;
  }

  Eigen::Vector3d BoresightAfter() const {
    Eigen::Vector3d move = Eigen::Vector3d::Zero();
    for (const ScreenedEffect& effect : final_.chosen) move += effect.boresight_rad;
    return Log(
        Eigen::Quaterniond(Exp(Eigen::Vector3d(-move)) * Exp(calibration_.boresight.angles_rad)));
  }

  // ---- Detection limits -------------------------------------------------------------------------

  void FillDetectionLimits(double threshold_nats) {
    out_.could_still_hide = ComputeDetectionLimits(*base_.screen, threshold_nats, options_.seed);
    for (DetectionLimit& hidden : EffectsInTrajectory(options_)) {
      out_.could_still_hide.push_back(std::move(hidden));
    }
  }

  void FillNotes() {
    std::vector<std::string>& notes = out_.validity.notes;
    notes.push_back("effects are linearised at the Gauss-Helmert adjustment");
    const ErrorScale& scale = base_.scale;
    if (scale.position > 1.0 || scale.attitude > 1.0) {
      notes.push_back(fmt::format(
          "effects are tested with trajectory errors of {:.2g} times the stated size in position "
          "and {:.2g} times in attitude, the most probable values",
          scale.position, scale.attitude));
    }
  }

  GapResult Result() {
    GapResult result;
    result.adapted = Adapted(flight_, out_);
    result.trajectory = *flight_.trajectory;
    result.boresight_rad =
        out_.verdict.effects.empty() ? calibration_.boresight.angles_rad : BoresightAfter();
    result.diagnosis = std::move(out_);
    return result;
  }

  const Flight& flight_;
  const GapOptions& options_;
  GaussHelmertCalibration calibration_;
  std::vector<StripInterval> strips_;
  LinearPairs pairs_;
  GaussHelmertLibrary library_;
  GaussHelmertEvidence evidence_;
  GapDiagnosis out_;
  LapTimes watch_;
  ExtendedPairFit base_, final_;
  ComparedPairs before_, after_;
  std::vector<ScreenedEffect> chosen_;
  std::vector<CompetingHypotheses> slots_;
  double explained_nats_ = 0.0;
  long outliers_ = 0;
};

GaussHelmertCalibration Calibrate(const Flight& flight, const GapOptions& options) {
  GaussHelmertFlightOptions gauss_helmert;
  gauss_helmert.threads = options.threads;
  gauss_helmert.interrupted = options.interrupted;
  if (options.progress) options.progress("Gauss-Helmert adjustment", 0.0);
  return CalibrateGaussHelmert(flight, gauss_helmert);
}

}  // namespace

GapResult DiagnoseGaussHelmert(const Flight& flight, const GapOptions& options) {
  const std::size_t pairs = flight.pairs ? flight.pairs->pairs.size() : 0;
  if (!flight.trajectory || !flight.config.lidar || pairs < kFewestPairsOfFlight) {
    return Unavailable(
        flight, options,
        fmt::format("without inertial and GNSS data a diagnosis needs a trajectory and at least {} "
                    "pairs; the flight has {} trajectory and {} pairs",
                    kFewestPairsOfFlight, flight.trajectory ? "a" : "no", pairs));
  }
  GaussHelmertDiagnosis diagnosis(flight, options, Calibrate(flight, options));
  return options.depth == GapOptions::Depth::kLimits ? diagnosis.Limits() : diagnosis.Run();
}

}  // namespace dn::internal
