#pragma once

#include <dn/montecarlo/blind_record.h>
#include <dn/report/distributions.h>

#include <array>
#include <string>
#include <vector>

namespace dn {

/// How often something happened.
struct Share {
  long hits = 0;
  long of = 0;

  void Count(bool hit) {
    hits += hit ? 1 : 0;
    ++of;
  }
  double value() const;  ///< NaN of nothing
  /// The probabilities that agree with it at 95 % (Wilson's interval of a binomial).
  Interval interval_95() const;
};

/// One tenth of the range of stated probabilities.
struct ReliabilityBin {
  double low = 0.0, high = 0.0;
  double stated = 0.0;  ///< mean of the probabilities in it; NaN of none
  Share true_ones;      ///< causes that are really there
};

/// Flights with one effect, of one name.
struct EffectScore {
  std::string effect;
  Share detected;
  Share named;             ///< the verdict names it and nothing else
  Share named_with_group;  ///< or it is in the credible set of a group
};

/// Flights with one effect, by its size (SizeOf).
struct SizeScore {
  double from = 0.0;
  Share detected;
  Share named;
  Share named_with_group;
};

/// Flights with one fixed effect, by how strongly it shows.
struct StrengthScore {
  double from_sigmas = 0.0;  ///< of the root of BlindSignature::lambda
  Share detected;
  Share named;
  Share named_with_group;
  Share calibrated_beyond_5_sigma;  ///< of those whose boresight `dn calibrate` gave as assumed
};

/// Flights with one outsider, or one effect left out, of one name.
struct OutsiderScore {
  std::string outsider;
  Share detected;
  Share rejected;  ///< called unknown, or partly so
};

/// Flights with an outsider, or a fixed effect left out, by what of its signature no fixed effect of
/// the table can take the place of: little, and the name of the nearest relative is all that can be
/// expected.
struct SignatureScore {
  double from_sigmas = 0.0;  ///< of the root of BlindSignature::lambda_left
  Share detected;
  Share rejected;  ///< of the detected ones: called unknown, or partly so
  Share misnamed;  ///< of the detected ones: one effect is named, and nothing left open
};

/// Boresights of one verdict of `dn calibrate`.
struct CalibrationScore {
  std::string verdict;
  long flights = 0;
  long beyond_5_sigma = 0;
  double rms_sigmas = 0.0;  ///< of all angles
};

/// How many flights of one content got a verdict.
struct VerdictCount {
  BlindContent content = BlindContent::kNothing;
  std::string verdict;
  long flights = 0;
};

/// Median and quartiles; NaN of nothing.
struct Quartiles {
  long count = 0;
  double low = 0.0, median = 0.0, high = 0.0;
};

/// How well a series of blind flights was diagnosed. Named strictly: the verdict's effects are
/// those of the flight. With groups: every effect of the flight is among them, or in the credible
/// set where the verdict is `group`.
struct BlindScore {
  long flights = 0;
  std::vector<std::string> failures;  ///< "flight 7: dn gap: ..."

  Share false_alarms;              ///< of the flights with nothing
  Interval alarms_allowed;         ///< holds 95 % of the shares that a level of 5 % gives
  Share false_names;               ///< flights with nothing of which an effect is named
  Quartiles null_p_value;          ///< of the flights with nothing: uniform when the level is right
  double null_uniformity_p = 1.0;  ///< of such p-values, if uniform (Kolmogorov and Smirnov)

  Share one_detected, one_named, one_named_with_group;
  Share two_detected, two_named, two_named_with_group;
  Share two_members;  ///< effects of flights with two that the verdict names
  long spurious = 0;  ///< names in verdicts on flights with effects, of what is not there
  Share outsider_detected;
  Share outsider_rejected;  ///< of the detected ones: unknown, or partial
  Share outsider_misnamed;  ///< of the detected ones: one effect is named, and nothing left open
  std::vector<VerdictCount> verdicts;
  std::array<SizeScore, 3> sizes;          ///< the smaller, the middle and the larger third
  std::array<StrengthScore, 4> strengths;  ///< below 4.5 sigma, 4.5 to 6, 6 to 8, above
  std::vector<EffectScore> effects;
  std::vector<OutsiderScore> outsiders;
  std::array<SignatureScore, 3> signatures;  ///< below 5 sigma, 5 to 8, above

  std::array<ReliabilityBin, 10> reliability;
  Quartiles truth_posterior;  ///< of the effect that is there, one effect, detected

  Share fixed_coverage;       ///< components within 1.96 sigma, of effects rightly named
  Share stochastic_coverage;  ///< the same of ratios, sigmas and correlation times

  std::vector<CalibrationScore> calibrated, adapted;  ///< by verdict
  Quartiles shrinkage_right, shrinkage_wrong;         ///< by whether the name is strictly right
  Quartiles diagnosis_time_s, calibration_time_s;
};

/// Scores the records. Throws InvalidInput where there is none.
BlindScore ScoreBlindFlights(const std::vector<BlindRecord>& records);

Json ToJson(const BlindScore& score);

/// The table that a person reads.
std::string FormatTable(const BlindScore& score);

/// One row for each flight: what it contains, what was said of it, errors of the boresight.
std::string FormatCsv(const std::vector<BlindRecord>& records);

/// True when the verdict's effects are exactly those of the flight.
bool NamedStrictly(const BlindRecord& record);

/// True when every effect of the flight is named, or in the credible set of a `group`.
bool NamedWithGroup(const BlindRecord& record);

}  // namespace dn
