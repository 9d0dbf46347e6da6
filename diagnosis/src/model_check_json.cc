#include "model_check_json.h"

#include <dn/adjustment/words.h>
#include <dn/rotation.h>

#include <vector>

#include "json_numbers.h"

namespace dn {
namespace {

Json GroupJson(const GroupCheck& group) {
  return {{"name", group.name},
          {"observations", group.observations},
          {"redundancy", group.redundancy},
          {"variance_ratio", group.variance_ratio},
          {"p_value", group.p_value},
          {"worst", {{"t_s", group.worst_t_s}, {"standardised", group.worst_standardised}}}};
}

Json CommonErrorJson(const CommonErrorCheck& common) {
  return {{"name", common.name},
          {"ratio", common.ratio},
          {"p_value", common.p_value},
          {"sigma", common.sigma},
          {"damage", common.max_shift_sigmas},
          {"explained", common.explained},
          {"covered", common.covered}};
}

/// Returns a shift of the boresight; null if the check has no boresight.
Json ShiftJson(const Eigen::Vector3d& shift_rad, bool has_boresight) {
  return has_boresight ? ToJson(shift_rad * kDegPerRad * 1e3) : Json(nullptr);
}

Json EffectJson(const EffectCheck& effect, bool has_boresight) {
  return {{"effect", effect.name},
          {"p_value", effect.p_value},
          {"estimate", ToJson(effect.estimate)},
          {"sigma", ToJson(effect.sigma)},
          {"unit", effect.unit},
          {"boresight_damage_mdeg", ShiftJson(effect.boresight_rad, has_boresight)},
          {"damage_sigmas", effect.max_shift_sigmas},
          {"log_evidence", effect.log_evidence},
          {"inseparable_from", effect.inseparable_from}};
}

Json DiscrepancyJson(const DiscrepancyCheck& discrepancy) {
  return {{"name", discrepancy.name},
          {"statistic", discrepancy.statistic},
          {"dof", discrepancy.dof},
          {"p_value", discrepancy.p_value},
          {"boresight_damage_mdeg", ShiftJson(discrepancy.boresight_rad, true)},
          {"damage_sigmas", discrepancy.max_shift_sigmas}};
}

Json UndetectableJson(const UndetectableEffect& effect, bool has_boresight) {
  return {{"effect", effect.name},
          {"component", effect.component.empty() ? Json(nullptr) : Json(effect.component)},
          {"usual", effect.usual},
          {"minimal_detectable", diagnosis_internal::Number(effect.minimal_detectable)},
          {"unit", effect.unit},
          {"boresight_damage_mdeg", ShiftJson(effect.boresight_rad, has_boresight)},
          {"damage_sigmas", effect.max_shift_sigmas}};
}

Json CompetingEffectJson(const CompetingEffectCheck& competing, bool has_boresight) {
  return {{"unknown", competing.unknown},
          {"rival", competing.competing_effect},
          {"log_evidence", competing.log_evidence},
          {"boresight_difference_mdeg", ShiftJson(competing.boresight_rad, has_boresight)},
          {"damage_sigmas", competing.max_shift_sigmas}};
}

Json PriorJson(const PriorCheck& prior) {
  return {{"unknown", prior.unknown},
          {"statistic", prior.statistic},
          {"dof", prior.dof},
          {"p_value", prior.p_value}};
}

Json GnssRunJson(const GnssRunCheck& run, bool has_boresight) {
  return {{"t0_s", run.t0_s},
          {"t1_s", run.t1_s},
          {"positions", run.positions},
          {"log_gnss_over_inertial", run.log_gnss_over_inertial},
          {"shape", run.is_gnss()       ? "gnss"
                    : run.is_inertial() ? "inertial"
                                        : "either"},
          {"boresight_shift_mdeg", ShiftJson(run.boresight_rad, has_boresight)},
          {"shift_sigmas", run.max_shift_sigmas}};
}

Json FindingJson(const Finding& finding) {
  return {{"contradicts", finding.contradicts}, {"text", Words(finding)}};
}

/// Converts each value; the options are passed on.
template <class T, class... Options>
Json ConvertAll(const std::vector<T>& values, Json (*convert)(const T&, Options...),
                Options... options) {
  Json list = Json::array();
  for (const T& value : values) list.push_back(convert(value, options...));
  return list;
}

}  // namespace

Json ModelCheckJson(const ModelCheck& check) {
  const bool has_boresight = check.of_boresight;
  return {{"groups", ConvertAll(check.groups, &GroupJson)},
          {"common_errors", ConvertAll(check.common_errors, &CommonErrorJson)},
          {"effects", ConvertAll(check.effects, &EffectJson, has_boresight)},
          {"departures", ConvertAll(check.discrepancies, &DiscrepancyJson)},
          {"unseen", ConvertAll(check.undetectable, &UndetectableJson, has_boresight)},
          {"rivals", ConvertAll(check.competing_effects, &CompetingEffectJson, has_boresight)},
          {"priors", ConvertAll(check.priors, &PriorJson)},
          {"gnss_runs", ConvertAll(check.gnss_runs, &GnssRunJson, has_boresight)},
          {"findings", ConvertAll(check.findings, &FindingJson)},
          {"effective_tests",
           check.effective_tests > 0.0 ? Json(check.effective_tests) : Json(nullptr)},
          {"p_value", check.p_value}};
}

}  // namespace dn
