#pragma once

#include <dn/blind_check/blind_flight.h>
#include <dn/report/json_reader.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// Result of a command on a flight, or the reason for its failure.
template <class T>
struct Outcome {
  std::optional<T> result;
  std::string failure;  ///< empty if there is a result or the command was not run
  double time_s = 0.0;
};

/// A cause in gap.json. Numbers that are missing there are NaN.
struct BlindCause {
  std::string effect;
  double posterior = 0.0;
  std::vector<double> estimate;  ///< order and units as in the table of effects
  std::vector<double> sigma;
};

/// Error of the boresight averaged over all hypotheses.
struct BlindAverage {
  Eigen::Vector3d error_sigmas = Eigen::Vector3d::Zero();  ///< (estimate - truth) / sigma
  double nees = 0.0;                                       ///< e^T C^-1 e, 3 degrees of freedom
};

/// Contents of gap.json that are scored.
struct BlindDiagnosis {
  bool detected = false;
  double p_value = 1.0;
  std::string verdict;  ///< kind of the verdict
  std::vector<std::string> effects;
  std::vector<std::string> credible_set;
  bool unknown = false;
  std::vector<BlindCause> causes;  ///< best first
  std::optional<double> shrinkage;
  std::optional<double> size_nats_per_obs;
  std::optional<BlindAverage> averaged;  ///< absent without a boresight
};

/// Contents of result.json that are scored.
struct BlindCalibration {
  std::string verdict;
  Eigen::Vector3d error_sigmas = Eigen::Vector3d::Zero();  ///< (estimate - truth) / sigma
  Eigen::Vector3d sigma_deg = Eigen::Vector3d::Zero();

  double worst() const { return error_sigmas.cwiseAbs().maxCoeff(); }
};

/// Noncentralities (squared sigmas) of a deviation from the model, without noise. `lambda` is the
/// total, `lambda_left` the part that no single fixed effect of the table can explain.
struct BlindSignature {
  double lambda = 0.0;
  double lambda_left = 0.0;
  std::string nearest;  ///< effect that explains the largest part
};

/// A flight of the series: its content, diagnosis and calibrations.
struct BlindRecord {
  int number = 1;
  std::uint64_t seed = 1;
  std::string base;
  BlindContent content = BlindContent::kNothing;
  std::vector<Effect> effects;
  std::optional<UnlistedEffect> outsider;
  Eigen::Vector3d boresight_deg = Eigen::Vector3d::Zero();  ///< true boresight
  std::size_t strips = 0;
  /// Signature of the single fixed effect of the flight. For an effect of the table lambda_left is
  /// 0, unless the diagnosis must not consider it.
  std::optional<BlindSignature> signature;
  Outcome<BlindDiagnosis> diagnosis;
  Outcome<BlindCalibration> calibrated;
  Outcome<BlindCalibration> adapted;  ///< calibration that also estimates the verdict's effects
};

/// Returns a record with the truth of a drawn flight, without results.
BlindRecord MakeTruthRecord(const BlindFlight& flight);

/// Reads gap.json and compares its averaged boresight with the true one. Throws InvalidInput with
/// the name of the missing key.
BlindDiagnosis DiagnosisFromGapJson(const JsonPlace& json,
                                    const Eigen::Vector3d& true_boresight_deg);

/// Reads result.json and compares its boresight with the true one. Throws InvalidInput with the
/// name of the missing key.
BlindCalibration CalibrationFromResultJson(const JsonPlace& json,
                                           const Eigen::Vector3d& true_boresight_deg);

/// These two functions convert a record to JSON and back without any loss of digits.
/// BlindRecordFromJson throws InvalidInput if the value is not a record or is out of range.
Json ToJson(const BlindRecord& record);
BlindRecord BlindRecordFromJson(const JsonPlace& json);

/// These two functions convert a content to its word in the records and back. RecordContent throws
/// InvalidInput for an unknown word.
const char* Word(BlindContent content);
BlindContent RecordContent(const std::string& word);

}  // namespace dn
