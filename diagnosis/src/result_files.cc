#include <dn/adjustment/achieved_accuracy.h>
#include <dn/adjustment/words.h>
#include <dn/diagnosis/control_output.h>
#include <dn/diagnosis/result_files.h>
#include <dn/geo/text_table.h>
#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "model_check_json.h"
#include "result_json.h"

namespace dn {

using diagnosis_internal::AssessmentJson;
using diagnosis_internal::BoresightJson;
using diagnosis_internal::TimingJson;

namespace {

Json ClockJson(const std::optional<ClockEstimate>& clock) {
  if (!clock) return nullptr;
  return {{"offset_s", clock->offset_s},
          {"sigma_offset_s", clock->sigma_offset_s},
          {"drift_ppm", clock->drift * 1e6},
          {"sigma_drift_ppm", clock->sigma_drift * 1e6},
          {"correlation", clock->correlation}};
}

Json ClocksJson(const Clocks& clocks) {
  return {{"gnss", ClockJson(clocks.gnss)}, {"lidar", ClockJson(clocks.lidar)}};
}

Json SigmaJson(const std::optional<Eigen::Vector3d>& sigma_rad) {
  return sigma_rad ? ToJson(*sigma_rad * kDegPerRad) : Json(nullptr);
}

Json ContributionJson(const EffectContribution& part) {
  return {{"effect", part.effect},
          {"unit", part.unit},
          {"estimate", ToJson(part.estimate)},
          {"sigma", ToJson(part.sigma)},
          {"prior", ToJson(part.prior)},
          {"sigma_deg", ToJson(part.angle_sigma_rad * kDegPerRad)},
          {"remedy", part.remedy}};
}

Json ContributionsJson(const std::vector<EffectContribution>& parts) {
  Json list = Json::array();
  for (const EffectContribution& part : parts) list.push_back(ContributionJson(part));
  return list;
}

/// Returns sigmas, covariance and correlation of the pure model.
Json ModelledSigmaJson(const BoresightResult& boresight) {
  const ModelledBoresight modelled = boresight.as_modelled.value_or(
      ModelledBoresight{boresight.angles_rad, boresight.covariance_rad2});
  return {{"sigma_deg", ToJson(modelled.sigma_rad() * kDegPerRad)},
          {"covariance_deg2", ToJsonMatrix(modelled.covariance_rad2 * kDegPerRad * kDegPerRad)},
          {"correlation", ToJsonMatrix(modelled.correlation())}};
}

Json ModelledJson(const BoresightResult& boresight) {
  Json json = ModelledSigmaJson(boresight);
  const Eigen::Vector3d angles_rad =
      boresight.as_modelled ? boresight.as_modelled->angles_rad : boresight.angles_rad;
  json["angles_deg"] = ToJson(angles_rad * kDegPerRad);
  return json;
}

void AppendRow(std::string* text, double t_s, std::initializer_list<Eigen::Vector3d> columns) {
  *text += FormatDouble(t_s);
  for (const Eigen::Vector3d& column : columns) {
    for (int i = 0; i < 3; ++i) *text += ", " + FormatDouble(column[i]);
  }
  *text += '\n';
}

}  // namespace

namespace diagnosis_internal {

Json TimingJson(const RunTimings& timings) {
  return {{"read", timings.read_s},
          {"solve", timings.solve_s},
          {"covariance", timings.covariance_s},
          {"total", timings.total_s}};
}

Json BoresightJson(const BoresightResult& boresight) {
  const Eigen::Vector3d sigma_deg = boresight.sigma_rad() * kDegPerRad;
  return {{"angles_deg", ToJson(boresight.angles_rad * kDegPerRad)},
          {"euler_zyx_deg", ToJson(boresight.euler_zyx_rad * kDegPerRad)},
          {"sigma_deg", ToJson(sigma_deg)},
          {"covariance_deg2", ToJsonMatrix(boresight.covariance_rad2 * kDegPerRad * kDegPerRad)},
          {"correlation", ToJsonMatrix(boresight.correlation())},
          {"sigma_apriori_deg", SigmaJson(boresight.sigma_apriori_rad)},
          {"sigma_scaled_deg", SigmaJson(boresight.sigma_scaled_rad)},
          {"as_modelled", ModelledJson(boresight)},
          {"contributions", ContributionsJson(boresight.contributions)}};
}

Json AssessmentJson(const BoresightResult& boresight) {
  return {{"verdict", Word(boresight.verdict)}, {"reasons", Words(boresight.reasons)}};
}

}  // namespace diagnosis_internal

Json UnknownsJson(const std::vector<UnknownEstimate>& unknowns) {
  Json json = Json::object();
  for (const UnknownEstimate& unknown : unknowns) {
    json[unknown.name] = {
        {"value", unknown.value}, {"sigma", unknown.sigma}, {"unit", unknown.unit}};
  }
  return json;
}

Json PredictedBoresightJson(const BoresightResult& boresight) {
  return {{"sigma_deg", ToJson(boresight.sigma_rad() * kDegPerRad)},
          {"covariance_deg2", ToJsonMatrix(boresight.covariance_rad2 * kDegPerRad * kDegPerRad)},
          {"correlation", ToJsonMatrix(boresight.correlation())},
          {"as_modelled", ModelledSigmaJson(boresight)},
          {"contributions", ContributionsJson(boresight.contributions)}};
}

Json AdjustmentJson(const AdjustmentFigures& figures) {
  return {{"sigma0", figures.sigma0},
          {"chi2", figures.chi2},
          {"redundancy", figures.redundancy},
          {"condition_number", nullptr},
          {"iterations", figures.iterations},
          {"converged", figures.converged},
          {"residual_initial_m", nullptr},
          {"residual_final_m", nullptr},
          {"nodes", figures.nodes},
          {"parameters", figures.parameters},
          {"imu_epochs", figures.imu_epochs},
          {"gnss_epochs", figures.gnss_epochs},
          {"correspondences", figures.correspondences},
          {"outliers", figures.outliers}};
}

Json CalibrationJson(const std::string& flight, const Adjustment& adjustment,
                     const TrajectoryResult& trajectory, const ModelCheck& check,
                     const BoresightResult& boresight, const std::vector<UnknownEstimate>& unknowns,
                     const std::vector<PairResidual>& pairs, const RunTimings& timings) {
  Json json;
  json["schema"] = "dn.result/1";
  json["flight"] = flight;
  json["method"] = "dn";
  json["boresight"] = BoresightJson(boresight);
  json["assessment"] = AssessmentJson(boresight);
  json["correlations"] = {{"boresight_to_accel_bias", CorrelationJson(boresight.accel_bias)},
                          {"boresight_to_gyro_bias", CorrelationJson(boresight.gyro_bias)}};
  json["estimates"] = UnknownsJson(unknowns);
  json["clocks"] = ClocksJson(check.clocks);
  Json figures = AdjustmentJson(trajectory.figures);
  if (trajectory.figures.surface_pairs + trajectory.figures.surface_outliers > 0) {
    figures["surface_pairs"] = trajectory.figures.surface_pairs;
    figures["surface_outliers"] = trajectory.figures.surface_outliers;
  }
  figures["condition_number"] = boresight.condition_number;
  figures["residual_initial_m"] = adjustment.residual_initial_m;
  figures["residual_final_m"] = adjustment.residual_final_m;
  json["adjustment"] = figures;
  json["strip_pairs"] = StripPairsJson(pairs);
  json["model_check"] = ModelCheckJson(check);
  if (check.control) json["control"] = ControlJson(*check.control);
  json["timing_s"] = TimingJson(timings);
  return json;
}

Json CalibrationJson(const std::string& flight, const GaussHelmertCalibration& calibration,
                     const ModelCheck& check, const std::vector<PairResidual>& pairs,
                     const RunTimings& timings) {
  return diagnosis_internal::FixedTrajectoryJson(flight, "gh", calibration, check,
                                                 {{"strip_pairs", StripPairsJson(pairs)}}, timings);
}

Json GaussHelmertReportJson(const GaussHelmertCalibration& calibration) {
  const GaussHelmertResult& adjustment = calibration.adjustment;
  const CorrelatedErrorCovariance& scatter = calibration.scatter;
  const TrajectoryAccuracy& accuracy = calibration.accuracy;
  const PoseInterpolation& interpolation = calibration.interpolation;
  return {{"rotation",
           calibration.options.model == BoresightModel::kExponential ? "exp" : "small_angle"},
          {"libor_compat", calibration.options.libor_compat},
          {"chi2_observations", adjustment.chi2_observations},
          {"chi2_conditions", adjustment.chi2_conditions},
          {"normal_matrix_per_rad2", ToJsonMatrix(adjustment.normal)},
          {"correlation_apriori", ToJsonMatrix(adjustment.correlation())},
          {"interpolation",
           {{"method", interpolation.method},
            {"median_step_s", interpolation.median_step_s},
            {"cubic_minus_linear_rms_deg", interpolation.cubic_minus_linear_rms_rad * kDegPerRad},
            {"cubic_minus_linear_max_deg", interpolation.cubic_minus_linear_max_rad * kDegPerRad}}},
          {"trajectory_sigma",
           {{"source", accuracy.source},
            {"position_ned_m", ToJson(accuracy.sigma_ned_m)},
            {"roll_pitch_heading_deg", ToJson(accuracy.sigma_rph_rad * kDegPerRad)}}},
          {"within_flight_scatter",
           {{"sigma_deg", ToJson(scatter.covariance_rad2.diagonal().cwiseSqrt() * kDegPerRad)},
            {"attitude_ratio", scatter.attitude_ratio},
            {"position_ratio", scatter.position_ratio},
            {"tau_s", scatter.tau_s > 0.0 ? Json(scatter.tau_s) : Json(nullptr)},
            {"evidence_nats", scatter.evidence_nats},
            {"nodes", scatter.nodes}}},
          {"strips",
           {{"count", calibration.diversity.strips},
            {"crossing", calibration.diversity.crossing},
            {"different_heights", calibration.diversity.heights}}}};
}

namespace {

Json MethodJson(const BoresightResult& boresight) {
  return {{"angles_deg", ToJson(boresight.angles_rad * kDegPerRad)},
          {"sigma_deg", ToJson(boresight.sigma_rad() * kDegPerRad)},
          {"verdict", Word(boresight.verdict)}};
}

}  // namespace

Json CorrelationJson(const BiasCorrelation& correlation) {
  return {{"at_barycentre", ToJsonMatrix(correlation.at_barycentre)},
          {"max_abs", correlation.max_abs},
          {"rms", correlation.rms}};
}

Json ComparisonJson(const std::string& flight,
                    const std::vector<std::pair<std::string, const BoresightResult*>>& methods,
                    const std::vector<std::pair<std::string, std::string>>& absent) {
  Json json;
  json["schema"] = "dn.comparison/1";
  json["flight"] = flight;
  json["methods"] = Json::object();
  for (const auto& [name, boresight] : methods) json["methods"][name] = MethodJson(*boresight);
  json["notes"] = Json::array();
  for (const auto& [name, reason] : absent) {
    json["methods"][name] = nullptr;
    json["notes"].push_back(fmt::format("{}: {}", name, reason));
  }
  json["differences"] = Json::array();
  for (std::size_t a = 0; a < methods.size(); ++a) {
    for (std::size_t b = a + 1; b < methods.size(); ++b) {
      const bool nested = methods[a].first != "planes" && methods[b].first != "planes";
      const MethodDifference difference =
          nested ? Compare(*methods[a].second, *methods[b].second)
                 : CompareIndependent(*methods[a].second, *methods[b].second);
      const Eigen::Vector3d sigma_rad = difference.sigma_rad();
      json["differences"].push_back(
          {{"methods", {methods[a].first, methods[b].first}},
           {"difference_deg", ToJson(difference.difference_rad * kDegPerRad)},
           {"sigma_deg", ToJson(sigma_rad * kDegPerRad)},
           {"significance", ToJson(difference.difference_rad.cwiseQuotient(sigma_rad).cwiseAbs())},
           {"chi2", difference.mahalanobis2},
           {"p_value", difference.p_value}});
    }
  }
  return json;
}

Json SmoothJson(const std::string& flight, const TrajectoryResult& trajectory,
                const std::vector<TrajectorySigma>& sigma, const ModelCheck& check,
                const std::vector<UnknownEstimate>& unknowns, const RunTimings& timings) {
  Json json;
  json["schema"] = "dn.smooth/1";
  json["flight"] = flight;
  json["assessment"] = {{"verdict", Word(check)}, {"reasons", Words(check.findings)}};
  if (!trajectory.sigma.empty()) {
    json["accuracy"] = AccuracyJson(SummariseAccuracy(sigma));
    json["accuracy_as_modelled"] = AccuracyJson(SummariseAccuracy(trajectory.sigma));
  }
  json["contributions"] = ContributionsJson(check.unmodelled ? check.unmodelled->contributions
                                                             : std::vector<EffectContribution>{});
  json["adjustment"] = AdjustmentJson(trajectory.figures);
  json["innovations"] = StatisticsToJson(trajectory.innovations);
  if (!trajectory.innovations.empty()) {
    json["innovations"]["gnss position"]["nis"] = trajectory.nis_position;
    if (json["innovations"].contains("gnss velocity")) {
      json["innovations"]["gnss velocity"]["nis"] = trajectory.nis_velocity;
    }
  }
  json["residuals"] = StatisticsToJson(trajectory.residuals);
  json["model_check"] = ModelCheckJson(check);
  json["estimates"] = UnknownsJson(unknowns);
  json["clocks"] = ClocksJson(check.clocks);
  json["timing_s"] = TimingJson(timings);
  return json;
}

std::string FormatTrajectorySigma(const std::vector<TrajectorySigma>& sigma) {
  std::string text = "# t, sigma E, N, U [m], v E, N, U [m/s], roll, pitch, heading [deg]\n";
  for (const TrajectorySigma& row : sigma) {
    AppendRow(&text, row.t_s, {row.position_enu_m, row.velocity_enu_mps, row.rph_rad * kDegPerRad});
  }
  return text;
}

std::string FormatBiases(const std::vector<BiasEstimate>& biases) {
  constexpr double kDegH = kDegPerRad * 3600.0;
  constexpr double kMg = 1e3 / kStandardGravityMps2;
  std::string text =
      "# t, gyro x, y, z [deg/h], accel x, y, z [mg], sigma gyro [deg/h], sigma accel [mg]\n";
  for (const BiasEstimate& row : biases) {
    AppendRow(&text, row.t_s,
              {row.gyro_radps * kDegH, row.accel_mps2 * kMg, row.sigma_gyro_radps * kDegH,
               row.sigma_accel_mps2 * kMg});
  }
  return text;
}

Json ReferenceErrorsJson(const Flight& flight, const std::vector<MapPose>& poses) {
  if (!flight.reference) return nullptr;
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d attitude = Eigen::Vector3d::Zero();
  double n = 0.0;
  for (const MapPose& pose : poses) {
    if (!flight.reference->Covers(pose.t_s)) continue;
    const MapPose truth = flight.reference->MapPoseAt(pose.t_s, flight.frame);
    const Eigen::Matrix3d R_enu_m = flight.frame.R_m_enu(truth.p_mb).transpose();
    position += (R_enu_m * (pose.p_mb - truth.p_mb)).cwiseAbs2();
    velocity += (R_enu_m * (pose.v_m - truth.v_m)).cwiseAbs2();
    Eigen::Vector3d difference = RollPitchHeading(ToNavPoint(pose, flight.frame).q_nb) -
                                 RollPitchHeading(ToNavPoint(truth, flight.frame).q_nb);
    for (int i = 0; i < 3; ++i)
      difference[i] = std::remainder(difference[i], 2.0 * std::numbers::pi);
    attitude += difference.cwiseAbs2();
    n += 1.0;
  }
  if (n == 0.0) return nullptr;
  const bool has_velocity = flight.reference->notes().velocity_from_file;
  return {
      {"nodes", static_cast<long>(n)},
      {"position_enu_rmse_m", ToJson((position / n).cwiseSqrt())},
      {"velocity_enu_rmse_mps", has_velocity ? ToJson((velocity / n).cwiseSqrt()) : Json(nullptr)},
      {"roll_pitch_heading_rmse_deg", ToJson((attitude / n).cwiseSqrt() * kDegPerRad)}};
}

}  // namespace dn
