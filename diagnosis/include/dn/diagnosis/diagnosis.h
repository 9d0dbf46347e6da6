#pragma once

#include <dn/flight/effect_times.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// What the diagnosis of a flight comes to; gap.json has the word of each.
enum class GapVerdictKind {
  kIdentified,   ///< the effects named explain the data, and nothing else does
  kGroup,        ///< the effects named do, or others that this flight cannot tell from them
  kPartial,      ///< named effects explain a part; something else is left
  kUnknown,      ///< the data depart from the model in a way that no effect of the library explains
  kNoGap,        ///< the data are those that the assumed model would produce
  kUnavailable,  ///< the flight cannot carry the diagnosis
};

/// "identified", "group", "partial", "unknown", "no_gap", "unavailable".
const char* Word(GapVerdictKind kind);

/// A place where the data depart from the model. The p-value holds for the family of all places.
struct GapLocation {
  std::string sensor;    ///< "gnss", "gyro", "accel", "lidar"
  std::string quantity;  ///< "position east", "p2p"
  std::string location;  ///< "strip pair 1-2, scan angle 20..30 deg", "0.01..0.02 Hz"
  double statistic = 0.0;
  double p_adjusted = 1.0;
};

/// An effect that was screened, in the unit of the table of effects.
struct GapCause {
  std::string effect;
  std::string unit;
  EffectTimes times;  ///< where the effect has a window or a start: the likeliest
  double log_evidence =
      0.0;                   ///< nats, against its absence, beside the other effects of the verdict
  double posterior = 0.0;    ///< probability that it is present, calibrated
  double p_value = 1.0;      ///< of the screen, for the family
  Eigen::VectorXd estimate;  ///< a fixed effect's components, a ratio, or sigmas then tau
  Eigen::VectorXd sigma;
  double absorbed_fraction = 0.0;  ///< share of the signature that the unknowns follow
  Eigen::Vector3d boresight_damage_rad = Eigen::Vector3d::Zero();
  std::vector<std::string> inseparable_from;
  std::optional<double> held_out_gain_nats;
  std::optional<double> shrinkage;
};

/// A departure from the model that is known by its place only: "laser vectors by scan angle". It
/// competes with the effects, so that what has no name is not given one.
struct GapDiscrepancy {
  std::string name;
  double log_evidence = 0.0;       ///< nats
  double posterior = 0.0;          ///< that it is the better account of a part of the gap
  std::optional<double> period_s;  ///< of an oscillation
  std::optional<double> tau_s;     ///< of what settles
};

/// How large the gap is: mean Kullback-Leibler divergence of predictive errors, nats/observation.
struct GapSize {
  double value = 0.0;
  double null_low = 0.0, null_high = 0.0;  ///< 95 % of the twins
  double upper_limit_95 = 0.0;
};

/// The gap in the user's units.
struct GapUserUnits {
  std::optional<double> p2p_excess_m;
  std::optional<double> gnss_excess_m;
  std::optional<double> boresight_inconsistency_rad;
  std::optional<Eigen::Vector3d> gh_minus_dn_rad;
};

/// One side of before and after.
struct GapState {
  double p_value = 1.0;
  double size_nats_per_obs = 0.0;
  std::optional<double> p2p_m;   ///< rms of the predicted misclosures
  std::optional<double> gnss_m;  ///< rms of the predicted position errors
  std::optional<Eigen::Vector3d> boresight_rad;
  std::optional<Eigen::Vector3d> boresight_sigma_rad;
};

/// How far the gap closes once the effects of the verdict are among the unknowns.
struct GapShrinkage {
  double fraction = 0.0;  ///< 1 - excess after / excess before of the omnibus statistic
  double interval_low = 0.0, interval_high = 0.0;  ///< 95 %
  std::optional<double> share_of_reachable;
  std::optional<double> held_out_gain_nats;
  std::optional<double> reachable_left_nats;
  GapState before, after;
};

/// What could be there without being found. Sizes in `unit`.
struct HiddenEffect {
  std::string effect;
  std::string unit;
  double minimal_detectable = 0.0;  ///< in the best-determined direction; infinite: never
  std::optional<double> minimal_identifiable;  ///< nothing where geometry never separates it
  Eigen::Vector3d boresight_damage_rad = Eigen::Vector3d::Zero();  ///< at the minimal detectable
  std::vector<std::string> inseparable_from;  ///< what it could be taken for, at any size
  /// Minimal detectable sizes of the components, each alone; infinite: never.
  Eigen::VectorXd detectable_by_component = {};
};

/// An effect that is named with a size far beyond the usual ones, while a discrepancy without a name
/// describes the data nearly as well.
struct GapImplausible {
  std::string effect;
  double usual_sizes = 0.0;  ///< of its first component that is so large
  std::string discrepancy;
};

struct GapVerdict {
  GapVerdictKind kind = GapVerdictKind::kNoGap;
  std::vector<std::string> effects;       ///< one for each effect that is present
  std::vector<std::string> credible_set;  ///< 95 %
  bool unknown = false;                   ///< a part of the gap has no name
  std::optional<GapImplausible> implausible;
  std::string tie_breaker;  ///< what to fly to tell the members of a group apart
  std::string text;         ///< one sentence that a person can act on
};

/// One statistic of the flight beside what twins without and with the effects make of it.
struct FingerprintValue {
  std::string name;  ///< as GapLocation: "lidar p2p, strip pair 1-2, mean"
  double value = 0.0;
  double null_mean = 0.0, null_sigma = 1.0;     ///< twins of the assumed model
  std::optional<double> twin_mean, twin_sigma;  ///< simulated twins with the effects
};

/// How far the diagnosis itself may be trusted.
struct GapValidity {
  long observations = 0;
  int twins = 0;       ///< linear
  int full_twins = 0;  ///< simulated anew and adjusted
  double alpha = 0.05;
  int tests = 0;
  double aa_p_value = 1.0;                      ///< twins against twins
  std::optional<double> full_against_linear_p;  ///< their location statistics
  std::optional<double> like_twins_p;  ///< of the flight among simulated twins with the effects
  std::vector<std::string> notes;
};

/// Everything that `dn gap` says about a flight.
struct GapDiagnosis {
  std::string flight;
  /// The pairs were adjusted on a given trajectory, which holds the errors of its sensors.
  bool trajectory_given = false;
  bool detected = false;
  double p_value = 1.0;
  GapSize size;
  GapUserUnits user_units;
  std::vector<GapLocation> where;
  std::vector<GapCause> causes;               ///< every effect screened, best first
  std::vector<GapDiscrepancy> discrepancies;  ///< likewise
  GapVerdict verdict;
  std::optional<GapShrinkage> shrinkage;
  std::vector<HiddenEffect> could_still_hide;
  std::vector<FingerprintValue> fingerprint;
  GapValidity validity;
  std::vector<std::pair<std::string, double>> timings_s;
};

}  // namespace dn
