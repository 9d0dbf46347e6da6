#include <dn/diagnosis/gap_output.h>
#include <dn/geo/local_frame.h>

#include "effect_words.h"
#include "json_numbers.h"

namespace dn {
namespace {

using diagnosis_internal::kMdegPerRad;
using diagnosis_internal::List;
using diagnosis_internal::Number;
using diagnosis_internal::Scaled;
using Eigen::Vector3d;

Json Pair(double low, double high) { return Json::array({Number(low), Number(high)}); }

Json Text(const std::string& text) { return text.empty() ? Json() : Json(text); }

Json GapPart(const GapDiagnosis& d) {
  const GapUserUnits& units = d.user_units;
  return {
      {"detected", d.detected},
      {"p_value", Number(d.p_value)},
      {"size_nats_per_obs",
       {{"value", Number(d.size.value)},
        {"null_interval_95", Pair(d.size.null_low, d.size.null_high)},
        {"upper_limit_95", Number(d.size.upper_limit_95)}}},
      {"user_units",
       {{"p2p_excess_mm", Scaled(units.p2p_excess_m, diagnosis_internal::kMmPerM)},
        {"gnss_excess_mm", Scaled(units.gnss_excess_m, diagnosis_internal::kMmPerM)},
        {"boresight_inconsistency_mdeg", Scaled(units.boresight_inconsistency_rad, kMdegPerRad)},
        {"gh_minus_dn_mdeg", Scaled(units.gh_minus_dn_rad, kMdegPerRad)}}}};
}

Json Where(const std::vector<GapLocation>& where) {
  Json list = Json::array();
  for (const GapLocation& place : where) {
    list.push_back({{"sensor", place.sensor},
                    {"quantity", place.quantity},
                    {"location", place.location},
                    {"statistic", Number(place.statistic)},
                    {"p_adjusted", Number(place.p_adjusted)}});
  }
  return list;
}

Json Cause(const GapCause& cause) {
  Json json = {{"effect", cause.effect},
               {"log_evidence", Number(cause.log_evidence)},
               {"posterior", Number(cause.posterior)},
               {"p_value", Number(cause.p_value)},
               {"estimate", List(cause.estimate)},
               {"sigma", List(cause.sigma)},
               {"unit", cause.unit}};
  if (cause.times.window_s) {
    json["window_s"] = Pair(cause.times.window_s->first, cause.times.window_s->second);
  }
  if (cause.times.t0_s) json["t0_s"] = Number(*cause.times.t0_s);
  json["absorbed_fraction"] = Number(cause.absorbed_fraction);
  json["boresight_damage_mdeg"] = List(Vector3d(kMdegPerRad * cause.boresight_rad));
  json["inseparable_from"] = cause.inseparable_from;
  json["prior_sigmas"] = Number(cause.prior_sigmas);
  json["within_prior"] = cause.prior_sigmas ? Json(cause.within_prior()) : Json(nullptr);
  json["left_nats"] = Number(cause.left_nats);
  json["held_out_gain_nats"] = Number(cause.held_out_gain_nats);
  json["shrinkage"] = Number(cause.shrinkage);
  return json;
}

Json Causes(const std::vector<GapCause>& causes) {
  Json list = Json::array();
  for (const GapCause& cause : causes) list.push_back(Cause(cause));
  return list;
}

Json Discrepancy(const GapDiscrepancy& one) {
  Json json{{"name", one.name}, {"log_evidence", Number(one.log_evidence)}};
  if (one.period_s) json["period_s"] = Number(*one.period_s);
  if (one.tau_s) json["tau_s"] = Number(*one.tau_s);
  return json;
}

Json Discrepancies(const std::vector<GapDiscrepancy>& discrepancies) {
  Json list = Json::array();
  for (const GapDiscrepancy& one : discrepancies) {
    list.push_back(Discrepancy(one));
    list.back()["posterior"] = Number(one.posterior);
  }
  return list;
}

Json HeavyTails(const std::vector<GapHeavyTails>& heavy_tails) {
  Json list = Json::array();
  for (const GapHeavyTails& tails : heavy_tails) {
    list.push_back({{"sensor", tails.sensor},
                    {"dof", tails.dof},
                    {"scale", tails.scale},
                    {"lead_nats", tails.lead_nats},
                    {"replaced", tails.replaced}});
  }
  return list;
}

Json VerdictPart(const GapVerdict& verdict) {
  return {{"kind", Word(verdict.kind)},
          {"effects", verdict.effects},
          {"credible_set", verdict.credible_set},
          {"unknown", verdict.unknown},
          {"heavy_tails", HeavyTails(verdict.heavy_tails)},
          {"tie_breaker", Text(verdict.tie_breaker)},
          {"text", verdict.text}};
}

Json Shrinkage(const std::optional<GapShrinkage>& shrinkage) {
  if (!shrinkage) return {};
  const GapState& before = shrinkage->before;
  const GapState& after = shrinkage->after;
  return {{"fraction", Number(shrinkage->fraction)},
          {"share_of_reachable", Number(shrinkage->share_of_reachable)},
          {"interval_95", Pair(shrinkage->interval_low, shrinkage->interval_high)},
          {"p_before", Number(before.p_value)},
          {"p_after", Number(after.p_value)},
          {"size_before", Number(before.size_nats_per_obs)},
          {"size_after", Number(after.size_nats_per_obs)},
          {"held_out_gain_nats", Number(shrinkage->held_out_gain_nats)},
          {"reachable_left_nats", Number(shrinkage->reachable_left_nats)},
          {"rest", shrinkage->rest ? Discrepancy(*shrinkage->rest) : Json()},
          {"p2p_mm_before", Scaled(before.p2p_m, diagnosis_internal::kMmPerM)},
          {"p2p_mm_after", Scaled(after.p2p_m, diagnosis_internal::kMmPerM)},
          {"gnss_mm_before", Scaled(before.gnss_m, diagnosis_internal::kMmPerM)},
          {"gnss_mm_after", Scaled(after.gnss_m, diagnosis_internal::kMmPerM)},
          {"boresight_before_deg", Scaled(before.boresight_rad, kDegPerRad)},
          {"boresight_after_deg", Scaled(after.boresight_rad, kDegPerRad)},
          {"boresight_sigma_before_deg", Scaled(before.boresight_sigma_rad, kDegPerRad)},
          {"boresight_sigma_after_deg", Scaled(after.boresight_sigma_rad, kDegPerRad)}};
}

Json Averaged(const std::optional<BoresightEstimate>& boresight) {
  if (!boresight) return {};
  Json rows = Json::array();
  for (Eigen::Index k = 0; k < 3; ++k) {
    const Vector3d row = boresight->covariance_rad2.row(k);
    rows.push_back(List(Vector3d(kDegPerRad * kDegPerRad * row)));
  }
  return {{"angles_deg", List(Vector3d(kDegPerRad * boresight->angles_rad))},
          {"sigma_deg", List(Vector3d(kDegPerRad * boresight->sigma_rad()))},
          {"covariance_deg2", rows}};
}

Json Fingerprint(const std::vector<FingerprintValue>& values) {
  Json list = Json::array();
  for (const FingerprintValue& value : values) {
    list.push_back({{"name", value.name},
                    {"value", Number(value.value)},
                    {"null_mean", Number(value.null_mean)},
                    {"null_sigma", Number(value.null_sigma)},
                    {"twin_mean", Number(value.simulated_mean)},
                    {"twin_sigma", Number(value.simulated_sigma)}});
  }
  return list;
}

Json Validity(const GapValidity& validity) {
  return {{"observations", validity.observations},
          {"twins", validity.replicates},
          {"full_twins", validity.simulated_replicates},
          {"alpha", Number(validity.alpha)},
          {"tests", validity.tests},
          {"aa_p_value", Number(validity.aa_p_value)},
          {"full_against_linear_p", Number(validity.full_against_linear_p)},
          {"like_twins_p", Number(validity.like_replicates_p)},
          {"notes", validity.notes}};
}

Json Timings(const std::vector<std::pair<std::string, double>>& timings_s) {
  Json json = Json::object();
  for (const auto& [stage, time_s] : timings_s) json[stage] = Number(time_s);
  return json;
}

}  // namespace

Json GapJson(const GapDiagnosis& diagnosis) {
  return {{"schema", "dn.gap/1"},
          {"flight", diagnosis.flight},
          {"trajectory_given", diagnosis.trajectory_given},
          {"gap", GapPart(diagnosis)},
          {"where", Where(diagnosis.where)},
          {"causes", Causes(diagnosis.causes)},
          {"discrepancies", Discrepancies(diagnosis.discrepancies)},
          {"outside",
           {{"prior", Number(diagnosis.outside_prior)},
            {"posterior", Number(diagnosis.outside_posterior)}}},
          {"verdict", VerdictPart(diagnosis.verdict)},
          {"shrinkage", Shrinkage(diagnosis.shrinkage)},
          {"boresight_averaged", Averaged(diagnosis.boresight_averaged)},
          {"could_still_hide", DetectionLimitsJson(diagnosis.could_still_hide)},
          {"fingerprint", Fingerprint(diagnosis.fingerprint)},
          {"validity", Validity(diagnosis.validity)},
          {"timings_s", Timings(diagnosis.timings_s)}};
}

}  // namespace dn
