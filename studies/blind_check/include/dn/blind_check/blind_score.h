#pragma once

#include <dn/blind_check/blind_record.h>
#include <dn/distributions.h>

#include <array>
#include <string>
#include <vector>

namespace dn {

/// Frequency of an event: `hits` of `of` cases.
struct Share {
  long hits = 0;
  long of = 0;

  void Count(bool hit) {
    hits += hit ? 1 : 0;
    ++of;
  }
  double value() const;  ///< hits / of; NaN if `of` is 0
  /// Returns the 95 % confidence interval of the probability (Wilson's binomial interval).
  Interval interval_95() const;
};

/// Causes whose stated probability is in one tenth of the range from 0 to 1.
struct ReliabilityBin {
  double low = 0.0, high = 0.0;
  double stated = 0.0;  ///< mean stated probability; NaN without causes
  Share true_causes;    ///< share of causes that are present in the flight
};

/// Scores of the flights that contain only the named effect.
struct EffectScore {
  std::string effect;
  Share detected;
  Share named;             ///< the verdict names only this effect
  Share named_with_group;  ///< as above, or it is in the credible set of a group
};

/// Scores of the flights with one effect in a class of sizes (DrawnSize).
struct SizeScore {
  double from = 0.0;
  Share detected;
  Share named;
  Share named_with_group;
};

/// Scores of the flights with one fixed effect in a class of signal strengths.
struct StrengthScore {
  double from_sigmas = 0.0;  ///< lower limit of sqrt(BlindSignature::lambda)
  Share detected;
  Share named;
  Share named_with_group;
  Share calibrated_beyond_5_sigma;  ///< verdict calibrated (not adapted), but error above 5 sigma
};

/// Scores of the flights with one named effect that the diagnosis does not have.
struct UnlistedEffectScore {
  std::string outsider;
  Share detected;
  Share rejected;  ///< verdict unknown or partial
};

/// Scores of the flights with an effect that the diagnosis does not have, in a class of the
/// unexplained signature. If little of the signature stays unexplained, the best possible diagnosis
/// names the most similar effect of the table.
struct SignatureScore {
  double from_sigmas = 0.0;  ///< lower limit of sqrt(BlindSignature::lambda_left)
  Share detected;
  Share rejected;  ///< verdict unknown or partial, among the detected flights
  Share misnamed;  ///< verdict identified, although wrong, among the detected flights
};

/// Boresight errors of the flights with one verdict of `dn calibrate`.
struct CalibrationScore {
  std::string verdict;
  long flights = 0;
  long beyond_5_sigma = 0;
  double rms_sigmas = 0.0;  ///< rms of error / sigma over all angles
};

/// Errors of the boresight averaged over all hypotheses, of the flights with one verdict of
/// `dn gap`.
struct AverageScore {
  std::string verdict;
  Share in_region_95;  ///< flights whose true boresight is in the 95 % region of the covariance
  Share angles_95;     ///< angles within 1.96 sigma
};

/// Number of flights with one content that got one verdict.
struct VerdictCount {
  BlindContent content = BlindContent::kNothing;
  std::string verdict;
  long flights = 0;
};

/// Median and quartiles; NaN if `count` is 0.
struct Quartiles {
  long count = 0;
  double low = 0.0, median = 0.0, high = 0.0;
};

/// Scores of the flights with several effects.
struct SeveralScore {
  Share detected, named, named_with_group;
  Share members;  ///< named effects among those of the flights
};

/// Scores of the diagnoses of a series of blind flights. `named`: the verdict's effects are exactly
/// those of the flight. `with_group`: each effect of the flight is one of the verdict's effects or,
/// for the verdict `group`, in the credible set.
struct BlindScore {
  long flights = 0;
  std::vector<std::string> failures;  ///< "flight 7: dn gap: ..."

  Share false_alarms;              ///< detections in flights without effects
  Interval alarms_allowed;         ///< 95 % interval of the false-alarm share at a level of 5 %
  Share false_names;               ///< flights without effects for which one is named
  Quartiles null_p_value;          ///< p-values without effects: uniform if the level is correct
  double null_uniformity_p = 1.0;  ///< p-value of their uniformity (Kolmogorov and Smirnov)

  Share one_detected, one_named, one_named_with_group;
  SeveralScore two, three;  ///< flights with two and with three effects
  long spurious = 0;        ///< named effects that are absent, in flights with other effects
  Share outsider_detected;
  Share outsider_rejected;  ///< verdict unknown or partial, among the detected flights
  Share outsider_misnamed;  ///< verdict identified, although wrong, among the detected flights
  std::vector<VerdictCount> verdicts;
  std::array<SizeScore, 3> sizes;          ///< small, medium and large effects
  std::array<StrengthScore, 4> strengths;  ///< below 4.5 sigma, 4.5 to 6, 6 to 8, above 8
  std::vector<EffectScore> effects;
  std::vector<UnlistedEffectScore> outsiders;
  std::array<SignatureScore, 3> signatures;  ///< below 5 sigma, 5 to 8, above 8

  std::array<ReliabilityBin, 10> reliability;
  Quartiles truth_posterior;  ///< posterior of the true effect, in detected flights with one effect

  Share fixed_coverage;       ///< components within 1.96 sigma, for correctly named effects
  Share stochastic_coverage;  ///< the same for ratios, sigmas and correlation times

  std::vector<CalibrationScore> calibrated, adapted;  ///< by verdict
  std::vector<AverageScore> averaged;                 ///< by verdict, then all flights
  Quartiles shrinkage_right, shrinkage_wrong;         ///< with correct and with wrong names
  Quartiles diagnosis_time_s, calibration_time_s;
};

/// Scores the records. Throws InvalidInput if there are none.
BlindScore ScoreBlindFlights(const std::vector<BlindRecord>& records);

Json ToJson(const BlindScore& score);

/// Formats the scores as a text table.
std::string FormatTable(const BlindScore& score);

/// Formats one CSV row per flight with its content, its verdict and the boresight errors.
std::string FormatCsv(const std::vector<BlindRecord>& records);

/// Returns true if the verdict's effects are exactly those of the flight.
bool NamedStrictly(const BlindRecord& record);

/// Returns true if every effect of the flight is named or in the credible set of a `group`.
bool NamedWithGroup(const BlindRecord& record);

}  // namespace dn
