#include "fixed_trajectory_source.h"

#include <dn/axis_names.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/interrupted.h>
#include <dn/log_sum.h>
#include <dn/rotation.h>
#include <dn/sim/random.h>
#include <dn/symmetric_eigen.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "boresight_average.h"
#include "decision.h"
#include "detection_limits.h"
#include "outlier_evidence.h"
#include "shrinkage.h"
#include "unavailable.h"

namespace dn::diagnosis_internal {
namespace {

constexpr std::size_t kFewestPairsOfFlight = 100;
// Evidence that larger trajectory errors must have. Good flights reach up to about half of it,
// because the model of the trajectory errors is not complete.
constexpr double kLargerErrorsNats = 20.0;
// Norm of a standardised misclosure that counts as an outlier, and the fraction of good pairs above
// it.
constexpr double kOutlierPairNorm = 4.6, kGoodNormsLost = 2e-4;

const PairFit& AsPairFit(const ExtendedFit& fit) { return static_cast<const PairFit&>(fit); }

GaussHelmertCalibration Calibrate(const Flight& flight, const GapOptions& options) {
  const std::size_t pairs = flight.pairs ? flight.pairs->pairs.size() : 0;
  if (!flight.trajectory || !flight.config.lidar || pairs < kFewestPairsOfFlight) {
    throw InvalidInput(
        fmt::format("without inertial and GNSS data a diagnosis needs a trajectory and at least {} "
                    "pairs; the flight has {} trajectory and {} pairs",
                    kFewestPairsOfFlight, flight.trajectory ? "a" : "no", pairs));
  }
  GaussHelmertFlightOptions gauss_helmert;
  gauss_helmert.threads = options.threads;
  gauss_helmert.interrupted = options.interrupted;
  if (options.progress) options.progress("Gauss-Helmert adjustment", 0.0);
  return CalibrateGaussHelmert(flight, gauss_helmert);
}

/// Returns a p-value. The mean likelihood ratio of the family exceeds 1 / p with probability p at
/// most.
double PByEvidence(const std::vector<HypothesisEvidence>& effects) {
  LogSum sum;
  for (const HypothesisEvidence& effect : effects) sum.Add(effect.log_evidence);
  return std::min(1.0, static_cast<double>(effects.size()) * std::exp(-sum.Value()));
}

/// Returns the p-value from the evidence alone. Replicates at one scale of the trajectory errors
/// do not show that this scale was itself estimated.
double PValue(const PairFit& fit) {
  const bool larger = fit.larger_errors_nats > kLargerErrorsNats;
  return std::min(PByEvidence(fit.effects), larger ? std::exp(-fit.larger_errors_nats) : 1.0);
}

/// Returns the evidence of the best explanation that was not selected.
double LeftNats(const PairFit& fit) {
  const double most = fit.effects.empty() ? 0.0 : std::max(0.0, fit.effects.front().log_evidence);
  return most + std::max(0.0, fit.larger_errors_nats);
}

std::vector<double> ReplicateSizes(const Comparison& compared) {
  std::vector<double> sizes;
  for (const ResidualSummary& one : compared.replicates.all) sizes.push_back(one.size_nats);
  std::sort(sizes.begin(), sizes.end());
  return sizes;
}

}  // namespace

FixedTrajectorySource::FixedTrajectorySource(const Flight& flight, const GapOptions& options)
    : flight_(flight),
      options_(options),
      calibration_(Calibrate(flight, options)),
      strips_(FindStrips(flight)),
      pairs_(LinearisePairs(flight, calibration_)),
      library_(MakeLibrary(flight, pairs_, strips_, MakeLibraryOptions(options))),
      fitter_(library_, pairs_, strips_, ScreensNoise()) {}

bool FixedTrajectorySource::Wanted(EffectId effect) const {
  return MakeLibraryOptions(options_).Wanted(effect);
}

/// Returns whether the noise of the pairs is screened. A robust loss also reduces the weight of
/// good pairs, and with it their apparent noise.
bool FixedTrajectorySource::ScreensNoise() const {
  return flight_.config.lidar->robust == RobustKind::kNone && Wanted(EffectId::kP2pNoiseScale);
}

std::unique_ptr<ExtendedFit> FixedTrajectorySource::Fit(
    const std::vector<HypothesisEvidence>& chosen) {
  auto fit = std::make_unique<PairFit>(fitter_.Fit(chosen));
  if (!Contains(chosen, EffectId::kP2pOutliers) && Wanted(EffectId::kP2pOutliers)) {
    AddOutliers(fit.get());
  }
  SetBoresights(*fit->screen, MakeUnmodelledPrior(flight_.config), TotalBoresight(*fit), fit.get());
  return fit;
}

/// Converts a scale relative to the smoother's accuracy to one relative to the sigmas at the ends
/// of the pairs. These sigmas come from the section `trajectory`.
ErrorScale FixedTrajectorySource::ScaleAtPairEnds(const ErrorScale& scale) const {
  const GaussHelmertEnd& end = calibration_.problem.pairs.front().i;
  const TrajectoryAccuracy& accuracy = calibration_.accuracy;
  return {scale.position * accuracy.sigma_ned_m.norm() / end.sigma_ned_m.norm(),
          scale.attitude * accuracy.sigma_rph_rad.norm() / end.sigma_rph_rad.norm()};
}

/// Adds the effect of outliers: the rejected pairs that trajectory errors do not explain.
void FixedTrajectorySource::AddOutliers(PairFit* fit) const {
  const GaussHelmertProblem& problem = calibration_.problem;
  const ErrorScale scale = ScaleAtPairEnds(fit->scale);
  std::vector<double> lengths_m;
  for (std::size_t k = 0; k < problem.pairs.size(); ++k) {
    if (calibration_.adjustment.weights[k] > 0.0) continue;
    const PairLinearisation at =
        LinearisePair(problem.pairs[k], problem.lever_arm_b_m, calibration_.options.model,
                      calibration_.adjustment.boresight_rad, PairCorrection::Zero());
    const Eigen::Matrix3d covariance = MisclosureCovariance(problem.pairs[k], at, scale);
    if (at.w.dot(covariance.llt().solve(at.w)) < kOutlierPairNorm * kOutlierPairNorm) continue;
    lengths_m.push_back(at.w.norm());
  }
  fit->outliers = static_cast<long>(lengths_m.size());
  fit->effects.push_back(OutlierEffect(EffectId::kP2pOutliers, fit->outliers,
                                       static_cast<long>(problem.pairs.size()), kGoodNormsLost,
                                       lengths_m));
  SortByEvidence(&fit->effects);
}

// ---- Replicates ---------------------------------------------------------------------------------

/// Returns the misclosures summed over each place, in units of their sigma.
Eigen::VectorXd FixedTrajectorySource::StandardisedPlaces(const JointScore& score,
                                                          const Eigen::VectorXd& s) const {
  std::vector<double> z;
  for (const PairPlace& place : library_.places) {
    for (Eigen::Index c = score.first[place.block]; c < score.first[place.block + 1]; ++c) {
      const bool absorbed = score.A(c, c) < 1e-7 * score.signature2[c];
      z.push_back(absorbed ? 0.0 : s[c] / std::sqrt(score.A(c, c)));
    }
  }
  return Eigen::VectorXd::Map(z.data(), static_cast<Eigen::Index>(z.size()));
}

/// Returns the statistics that Summarise evaluates.
std::vector<LocationStatistic> FixedTrajectorySource::Statistics() const {
  std::vector<LocationStatistic> statistics;
  for (const PairPlace& place : library_.places) {
    for (const char* axis : kEnu) {
      statistics.push_back({"lidar", std::string("p2p ") + axis, place.location});
    }
  }
  statistics.push_back({"lidar", "p2p, mean square", "the whole flight"});
  statistics.push_back({"lidar", "p2p, outliers", "the whole flight"});
  return statistics;
}

ResidualSummary FixedTrajectorySource::Summarise(const ScaledScores& at,
                                                 const Eigen::VectorXd& s) const {
  const double n = fitter_.observations();
  ResidualSummary appearance;
  const Eigen::VectorXd places = StandardisedPlaces(at.screen.score(), s);
  appearance.locations.resize(places.size() + 2);
  appearance.locations << places, (at.chi2 - n) / std::sqrt(2.0 * n), at.outlier_sigmas;
  const Eigen::VectorXd of_families = at.screen.LogEvidences(s);
  appearance.log_evidence.resize(of_families.size() + 1);
  appearance.log_evidence << of_families, fitter_.NoiseEvidence(at.chi2);
  appearance.size_nats = std::max(0.0, appearance.log_evidence.maxCoeff()) / n;
  appearance.pair_rms_m = PairSigma() * std::sqrt(at.chi2 / n) * at.white / fitter_.min_white();
  return appearance;
}

double FixedTrajectorySource::PairSigma() const {
  double sum = 0.0;
  for (const std::size_t k : pairs_.pair) {
    sum += calibration_.problem.pairs[k].covariance_m2.trace() / 3.0;
  }
  return std::sqrt(sum / static_cast<double>(pairs_.pair.size()));
}

/// Returns the excess number of outliers in sigmas. The root of a count has a constant variance
/// (Anscombe).
double FixedTrajectorySource::OutlierExcess(const PairFit& fit) const {
  if (Contains(fit.chosen, EffectId::kP2pOutliers)) return 0.0;
  const double typical = kGoodNormsLost * static_cast<double>(calibration_.problem.pairs.size());
  const double more =
      2.0 * (std::sqrt(static_cast<double>(fit.outliers) + 0.375) - std::sqrt(typical + 0.375));
  return std::max(0.0, more);
}

Comparison FixedTrajectorySource::Compare(const ExtendedFit& fit) const {
  const PairFit& own = AsPairFit(fit);
  return Compare(ScaledScores{*own.screen, own.chi2, own.scale.white, OutlierExcess(own)});
}

/// Compares the scores with replicates that have the covariance of a flight without any effect.
Comparison FixedTrajectorySource::Compare(const ScaledScores& at) const {
  const JointScore& score = at.screen.score();
  const SymmetricEigen eigen(score.A);
  const Eigen::MatrixXd root = eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
  const double n = fitter_.observations();
  Comparison out;
  for (int k = 0; k < NumReplicates(options_.depth); ++k) {
    if (options_.interrupted && options_.interrupted()) throw Interrupted();
    Random random(options_.seed, "twin/" + std::to_string(k));
    Eigen::VectorXd noise(root.cols());
    for (Eigen::Index row = 0; row < noise.size(); ++row) noise[row] = random.Normal();
    const double chi2 = std::max(0.0, n + std::sqrt(2.0 * n) * random.Normal());
    out.replicates.all.push_back(
        Summarise({at.screen, chi2, at.white, random.Normal()}, root * noise));
  }
  out.appearance = Summarise(at, score.s);
  out.statistics = Statistics();
  out.test = CompareWithReplicates(out.appearance, out.replicates);
  return out;
}

// ---- The gap ------------------------------------------------------------------------------------

long FixedTrajectorySource::observations(const ExtendedFit& /*fit*/) const {
  return static_cast<long>(fitter_.observations());
}

GapMeasure FixedTrajectorySource::Measure(const ExtendedFit& base, const Comparison& before) const {
  const PairFit& fit = AsPairFit(base);
  const double n = fitter_.observations();
  const std::vector<double> sizes = ReplicateSizes(before);
  const auto at = [&](double p) {
    return sizes[static_cast<std::size_t>(p * static_cast<double>(sizes.size() - 1))];
  };
  GapMeasure measure;
  measure.p_value = PValue(fit);
  measure.size.value = LeftNats(fit) / n;
  measure.size.null_low = at(0.025);
  measure.size.null_high = at(0.975);
  measure.size.upper_limit_95 = std::max(0.0, measure.size.value - at(0.05)) + at(0.95);
  measure.user_units.p2p_excess_m =
      before.appearance.pair_rms_m * std::sqrt(std::max(0.0, 1.0 - n / std::max(n, fit.chi2)));
  return measure;
}

bool FixedTrajectorySource::GapRemains(const ExtendedFit& final, const Comparison& /*after*/,
                                       double /*threshold_nats*/) const {
  return PValue(AsPairFit(final)) <= options_.alpha;
}

/// The reduction is that of LeftNats beyond its mean over replicates.
GapShrinkage FixedTrajectorySource::Shrinkage(const BeforeAndAfter& fits) const {
  const PairFit &base = AsPairFit(fits.base), &final = AsPairFit(fits.final);
  const double n = fitter_.observations();
  const std::vector<double> sizes = ReplicateSizes(fits.after);
  double typical = 0.0;
  for (const double size : sizes) typical += size / static_cast<double>(sizes.size());
  std::vector<double> deviations;
  for (const double size : sizes) deviations.push_back(n * (size - typical));
  GapShrinkage shrinkage = MakeShrinkage(std::max(LeftNats(base) - n * typical, 1.0),
                                         LeftNats(final) - n * typical, std::move(deviations));
  const BoresightEstimate after = TotalBoresight(final);
  shrinkage.before.p_value = PValue(base);
  shrinkage.before.size_nats_per_obs = LeftNats(base) / n;
  shrinkage.before.p2p_m = fits.before.appearance.pair_rms_m;
  shrinkage.before.boresight_rad = calibration_.boresight.angles_rad;
  shrinkage.before.boresight_sigma_rad = calibration_.boresight.sigma_rad();
  shrinkage.after.p_value = PValue(final);
  shrinkage.after.size_nats_per_obs = LeftNats(final) / n;
  shrinkage.after.p2p_m = fits.after.appearance.pair_rms_m;
  shrinkage.after.boresight_rad = after.angles_rad;
  shrinkage.after.boresight_sigma_rad = after.sigma_rad();
  return shrinkage;
}

void FixedTrajectorySource::ListPlaces(const ExtendedFit& base, const Comparison& /*before*/,
                                       const ExtendedFit& last, GapDiagnosis* diagnosis) const {
  const double larger_nats = AsPairFit(last).larger_errors_nats;
  if (larger_nats > kLargerErrorsNats) {
    diagnosis->where.push_back({"trajectory", "time-correlated errors larger than stated",
                                "the whole flight", larger_nats, std::exp(-larger_nats)});
  }
  const PairFit& fit = AsPairFit(base);
  const Comparison stated = Compare(ScaledScores{
      *fit.with_stated_errors, fit.chi2_with_stated_errors, fit.scale.white, OutlierExcess(fit)});
  FillFingerprint(stated, std::numeric_limits<std::size_t>::max(), diagnosis);
  if (diagnosis->detected) AppendPlaces(stated, options_.alpha, diagnosis);
}

std::vector<DetectionLimit> FixedTrajectorySource::Limits(const ExtendedFit& base,
                                                          double threshold_nats) const {
  const PairFit& fit = AsPairFit(base);
  const bool stated = options_.depth == GapOptions::Depth::kLimits;
  std::vector<DetectionLimit> limits = ComputeDetectionLimits(
      stated ? *fit.with_stated_errors : *fit.screen, threshold_nats, options_.seed);
  for (DetectionLimit& absorbed : EffectsInTrajectory(options_)) {
    limits.push_back(std::move(absorbed));
  }
  return limits;
}

std::vector<std::string> FixedTrajectorySource::Notes(const ExtendedFit& base) const {
  std::vector<std::string> notes{"effects are linearised at the Gauss-Helmert adjustment"};
  const ErrorScale& scale = AsPairFit(base).scale;
  if (scale.position > 1.0 || scale.attitude > 1.0) {
    notes.push_back(fmt::format(
        "effects are tested with trajectory errors of {:.2g} times the stated size in position "
        "and {:.2g} times in attitude, the most probable values",
        scale.position, scale.attitude));
  }
  return notes;
}

Trajectory FixedTrajectorySource::MakeTrajectory(const ExtendedFit& /*fit*/) const {
  return *flight_.trajectory;
}

BoresightEstimate FixedTrajectorySource::TotalBoresight(const PairFit& fit) const {
  return {Boresight(fit), calibration_.boresight.covariance_rad2 + fit.boresight_covariance_rad2};
}

Eigen::Vector3d FixedTrajectorySource::Boresight(const ExtendedFit& fit) const {
  Eigen::Vector3d move = Eigen::Vector3d::Zero();
  for (const HypothesisEvidence& effect : fit.chosen) move += effect.boresight_rad;
  return Log(
      Eigen::Quaterniond(Exp(Eigen::Vector3d(-move)) * Exp(calibration_.boresight.angles_rad)));
}

}  // namespace dn::diagnosis_internal
