#pragma once

#include <dn/adjustment/checks.h>
#include <dn/files/effect_times.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// Verdict of a diagnosis; the words in gap.json are those of Word().
enum class GapVerdictKind {
  kIdentified,  ///< the named effects explain the data, and no others do
  kGroup,  ///< the named effects explain the data, but this flight cannot separate them from others
  kPartial,      ///< the named effects explain a part of the gap; a significant part remains
  kUnknown,      ///< no effect of the library explains the gap
  kNoGap,        ///< the data agree with the assumed model
  kUnavailable,  ///< not enough data for a diagnosis
};

/// Returns "identified", "group", "partial", "unknown", "no_gap" or "unavailable".
const char* Word(GapVerdictKind kind);

/// A place where the data differ from the model. The p-value is adjusted for the number of places.
struct GapLocation {
  std::string sensor;    ///< "gnss", "gyro", "accel", "lidar"
  std::string quantity;  ///< "position east", "p2p"
  std::string location;  ///< "strip pair 1-2, scan angle 20..30 deg", "0.01..0.02 Hz"
  double statistic = 0.0;
  double p_adjusted = 1.0;
};

/// A screened effect, in the unit of the table of effects. The evidence is given the other effects
/// of the verdict; the p-value of the screening test is adjusted for the family of effects.
struct GapCause : EffectEvidence {
  std::string effect;
  std::string unit;
  EffectTimes times;               ///< most probable window or start, if the effect has one
  double posterior = 0.0;          ///< calibrated probability that the effect is present
  double absorbed_fraction = 0.0;  ///< share of the signature absorbed by the unknowns
  /// Evidence with the named effects in the model, nats; absent for these effects.
  std::optional<double> left_nats;
  std::vector<std::string> inseparable_from;
  std::optional<double> held_out_gain_nats;
  std::optional<double> shrinkage;
};

/// An unmodelled discrepancy, known by its place only, for example "laser vectors by scan angle".
/// It competes with the effects, so that physics outside the library is not given a wrong name.
struct GapDiscrepancy {
  std::string name;
  double log_evidence = 0.0;  ///< nats
  /// Probability that it explains a part of the gap better than the effects.
  double posterior = 0.0;
  std::optional<double> period_s;  ///< period of an oscillation
  std::optional<double> tau_s;     ///< time constant of a decay
};

/// Size of the gap: mean Kullback-Leibler divergence of the predictive errors, nats per
/// observation.
struct GapSize {
  double value = 0.0;
  double null_low = 0.0, null_high = 0.0;  ///< 95 % interval of the replicates
  double upper_limit_95 = 0.0;
};

/// The gap in the user's units.
struct GapUserUnits {
  std::optional<double> p2p_excess_m;
  std::optional<double> gnss_excess_m;
  std::optional<double> boresight_inconsistency_rad;
  std::optional<Eigen::Vector3d> gh_minus_dn_rad;
};

/// State of the flight before or after the effects are added.
struct GapState {
  double p_value = 1.0;
  double size_nats_per_obs = 0.0;
  std::optional<double> p2p_m;   ///< rms of the predicted pair misclosures
  std::optional<double> gnss_m;  ///< rms of the predicted position errors
  std::optional<Eigen::Vector3d> boresight_rad;
  std::optional<Eigen::Vector3d> boresight_sigma_rad;
};

/// Reduction of the gap once the effects of the verdict are among the unknowns.
struct GapShrinkage {
  double fraction = 0.0;  ///< 1 - excess after / excess before of the omnibus statistic
  double interval_low = 0.0, interval_high = 0.0;  ///< 95 %
  std::optional<double> share_of_reachable;
  std::optional<double> held_out_gain_nats;
  std::optional<double> reachable_left_nats;
  GapState before, after;
  /// Most probable unmodelled discrepancy beyond these effects, if its evidence is significant.
  std::optional<GapDiscrepancy> rest;
};

/// Total angles of the boresight with the covariance of a left rotation.
struct BoresightEstimate {
  Eigen::Vector3d angles_rad = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_rad2 = Eigen::Matrix3d::Zero();

  Eigen::Vector3d sigma_rad() const { return covariance_rad2.diagonal().cwiseSqrt(); }
};

/// Detection limits of an effect, in `unit`: up to these sizes it can stay undetected.
struct DetectionLimit {
  std::string effect;
  std::string unit;
  /// Minimal detectable bias in the best-determined direction; infinite if no size is detectable.
  double minimal_detectable = 0.0;
  /// Smallest size that can be named correctly; nullopt if the geometry never separates the effect.
  std::optional<double> minimal_identifiable;
  /// External reliability: shift of the boresight caused by a bias of size `minimal_detectable`.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
  std::vector<std::string> inseparable_from;  ///< effects that it can be mistaken for at any size
  /// Minimal detectable bias of each component alone; infinite if no size is detectable.
  Eigen::VectorXd detectable_by_component = {};
};

/// A named effect whose size is far above typical, while an unmodelled discrepancy describes the
/// data almost equally well.
struct GapImplausible {
  std::string effect;
  /// Size in multiples of the typical one, for the first component that is implausibly large.
  double typical_sizes = 0.0;
  std::string discrepancy;
};

/// Noise of a sensor with heavier tails than normal noise. The selection had taken outliers, or
/// outliers and noise of another size, for it; Student's t distribution describes the residuals
/// better.
struct GapHeavyTails {
  std::string sensor;      ///< "gnss" or "lidar"
  double dof = 0.0;        ///< degrees of freedom of Student's t
  double scale = 1.0;      ///< scale of Student's t, in sigmas of the stated noise
  double lead_nats = 0.0;  ///< log evidence of Student's t, less that of the replaced effects
  std::vector<std::string> replaced;  ///< names of these effects
};

/// Conclusion of a diagnosis.
struct GapVerdict {
  GapVerdictKind kind = GapVerdictKind::kNoGap;
  std::vector<std::string> effects;       ///< one for each effect that is present
  std::vector<std::string> credible_set;  ///< 95 % credible set
  bool unknown = false;                   ///< no effect explains a part of the gap
  /// With heavy tails: an unmodelled discrepancy is also present, other than the tails.
  bool rest = false;
  std::vector<GapHeavyTails> heavy_tails;  ///< at most one per sensor
  std::optional<GapImplausible> implausible;
  std::string tie_breaker;  ///< what to fly to separate the members of a group
  std::string text;         ///< one sentence that says what the user should do
};

/// A statistic of the flight, with its distribution over replicates without and with the effects.
struct FingerprintValue {
  std::string name;  ///< name as in GapLocation: "lidar p2p, strip pair 1-2, mean"
  double value = 0.0;
  double null_mean = 0.0, null_sigma = 1.0;  ///< over replicates of the assumed model
  std::optional<double> simulated_mean,
      simulated_sigma;  ///< over simulated replicates with the effects
};

/// Reliability of the diagnosis itself.
struct GapValidity {
  long observations = 0;
  int replicates = 0;            ///< linear replicates
  int simulated_replicates = 0;  ///< replicates that were simulated and adjusted
  double alpha = 0.05;
  int tests = 0;
  double aa_p_value = 1.0;  ///< test of replicates against replicates
  /// p-value of the location statistics of simulated against linear replicates.
  std::optional<double> full_against_linear_p;
  /// p-value of the flight among simulated replicates with the effects.
  std::optional<double> like_replicates_p;
  std::vector<std::string> notes;
};

/// All results of `dn gap` for a flight.
struct GapDiagnosis {
  std::string flight;
  /// True if the pairs were adjusted on a given trajectory, which contains the errors of its
  /// sensors.
  bool trajectory_given = false;
  /// True if the results of `dn calibrate` contain the tolerances of the sensors.
  bool with_tolerances = false;
  bool detected = false;
  double p_value = 1.0;
  GapSize size;
  GapUserUnits user_units;
  std::vector<GapLocation> where;
  std::vector<GapCause> causes;               ///< every screened effect, most probable first
  std::vector<GapDiscrepancy> discrepancies;  ///< every unmodelled discrepancy, most probable first
  GapVerdict verdict;
  /// Probability that what happened is not in the library: assumed, if something did, and given
  /// the data.
  double outside_prior = 0.0, outside_posterior = 0.0;
  std::optional<GapShrinkage> shrinkage;
  /// Boresight over all hypotheses by their probabilities; absent without pairs.
  std::optional<BoresightEstimate> boresight_averaged;
  std::vector<DetectionLimit> could_still_hide;
  std::vector<FingerprintValue> fingerprint;
  GapValidity validity;
  std::vector<std::pair<std::string, double>> timings_s;
};

}  // namespace dn
