#pragma once

#include <dn/montecarlo/blind_flight.h>
#include <dn/report/json.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace dn {

/// What a program made of a flight: a result, or why there is none.
template <class T>
struct Outcome {
  std::optional<T> result;
  std::string failure;  ///< empty where there is a result, or where nothing was tried
  double time_s = 0.0;
};

/// A cause of gap.json; NaN for a number that it leaves out.
struct BlindCause {
  std::string effect;
  double posterior = 0.0;
  std::vector<double> estimate;  ///< in the order and unit of the table of effects
  std::vector<double> sigma;
};

/// What is scored of gap.json.
struct BlindDiagnosis {
  bool detected = false;
  double p_value = 1.0;
  std::string verdict;  ///< its kind
  std::vector<std::string> effects;
  std::vector<std::string> credible_set;
  bool unknown = false;
  std::vector<BlindCause> causes;  ///< best first
  std::optional<double> shrinkage;
  std::optional<double> size_nats_per_obs;
};

/// What is scored of a result.json.
struct BlindCalibration {
  std::string verdict;
  Eigen::Vector3d error_sigmas = Eigen::Vector3d::Zero();  ///< (estimate - truth) / sigma
  Eigen::Vector3d sigma_deg = Eigen::Vector3d::Zero();

  double worst() const { return error_sigmas.cwiseAbs().maxCoeff(); }
};

/// How a departure from the model would show without noise, and what of that no single fixed effect
/// of the table can take the place of: noncentralities, squares of numbers of sigmas.
struct BlindSignature {
  double lambda = 0.0;
  double lambda_left = 0.0;
  std::string nearest;  ///< the effect that takes most of it
};

/// A flight of the series: what it contains, and what was said of it.
struct BlindRecord {
  int number = 1;
  std::uint64_t seed = 1;
  std::string base;
  BlindContent content = BlindContent::kNothing;
  std::vector<Effect> effects;
  std::optional<Outsider> outsider;
  Eigen::Vector3d boresight_deg = Eigen::Vector3d::Zero();  ///< true
  std::size_t strips = 0;
  /// Of the one fixed effect or the outsider in it; of an effect of the table nothing is left unless
  /// the diagnosis is without it.
  std::optional<BlindSignature> signature;
  Outcome<BlindDiagnosis> diagnosis;
  Outcome<BlindCalibration> calibrated;
  Outcome<BlindCalibration> adapted;  ///< with the effects of the verdict among the unknowns
};

/// The truth of a drawn flight, with nothing said of it yet.
BlindRecord TruthOf(const BlindFlight& flight);

/// Reads gap.json. Throws InvalidInput naming what is missing.
BlindDiagnosis DiagnosisFromGapJson(const Json& gap);

/// Reads result.json and compares its boresight with the true one. Throws InvalidInput naming what
/// is missing.
BlindCalibration CalibrationFromResultJson(const Json& result,
                                           const Eigen::Vector3d& true_boresight_deg);

/// A record as JSON, and back: doubles survive unchanged. The second throws Json::exception or
/// InvalidInput for what is no record.
Json ToJson(const BlindRecord& record);
BlindRecord BlindRecordFromJson(const Json& json);

/// "nothing", "one", "two", "outsider", "left out"; and back, throws InvalidInput for no such word.
const char* Word(BlindContent content);
BlindContent ContentOf(const std::string& word);

}  // namespace dn
