#include "model_check_json.h"

#include <dn/adjustment/words.h>
#include <dn/rotation.h>

#include <cmath>

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
          {"explained", common.explained}};
}

Json EffectJson(const EffectCheck& effect, bool has_boresight) {
  return {{"effect", effect.name},
          {"p_value", effect.p_value},
          {"estimate", ToJson(effect.estimate)},
          {"sigma", ToJson(effect.sigma)},
          {"unit", effect.unit},
          {"boresight_damage_mdeg",
           has_boresight ? ToJson(effect.boresight_rad * kDegPerRad * 1e3) : Json(nullptr)},
          {"damage_sigmas", effect.max_shift_sigmas},
          {"log_evidence", effect.log_evidence},
          {"inseparable_from", effect.inseparable_from}};
}

Json DepartureJson(const DiscrepancyCheck& departure) {
  return {{"name", departure.name},
          {"statistic", departure.statistic},
          {"dof", departure.dof},
          {"p_value", departure.p_value},
          {"boresight_damage_mdeg", ToJson(departure.boresight_rad * kDegPerRad * 1e3)},
          {"damage_sigmas", departure.max_shift_sigmas}};
}

Json UnseenJson(const UndetectableEffect& unseen, bool has_boresight) {
  const bool ever = std::isfinite(unseen.minimal_detectable);
  return {{"effect", unseen.name},
          {"component", unseen.component.empty() ? Json(nullptr) : Json(unseen.component)},
          {"usual", unseen.usual},
          {"minimal_detectable", ever ? Json(unseen.minimal_detectable) : Json(nullptr)},
          {"unit", unseen.unit},
          {"boresight_damage_mdeg",
           has_boresight ? ToJson(unseen.boresight_rad * kDegPerRad * 1e3) : Json(nullptr)},
          {"damage_sigmas", unseen.max_shift_sigmas}};
}

Json RivalJson(const CompetingEffectCheck& rival, bool has_boresight) {
  return {{"unknown", rival.unknown},
          {"rival", rival.rival},
          {"log_evidence", rival.log_evidence},
          {"boresight_difference_mdeg",
           has_boresight ? ToJson(rival.boresight_rad * kDegPerRad * 1e3) : Json(nullptr)},
          {"damage_sigmas", rival.max_shift_sigmas}};
}

template <class T, class Convert>
Json List(const std::vector<T>& values, const Convert& convert) {
  Json list = Json::array();
  for (const T& value : values) list.push_back(convert(value));
  return list;
}

}  // namespace

Json ModelCheckJson(const ModelCheck& check) {
  return {{"groups", List(check.groups, GroupJson)},
          {"common_errors", List(check.common_errors, CommonErrorJson)},
          {"effects",
           List(check.effects,
                [&](const EffectCheck& effect) { return EffectJson(effect, check.of_boresight); })},
          {"departures", List(check.departures, DepartureJson)},
          {"unseen", List(check.unseen,
                          [&](const UndetectableEffect& unseen) {
                            return UnseenJson(unseen, check.of_boresight);
                          })},
          {"rivals", List(check.competing_effects,
                          [&](const CompetingEffectCheck& rival) {
                            return RivalJson(rival, check.of_boresight);
                          })},
          {"priors", List(check.priors,
                          [](const PriorCheck& prior) {
                            return Json{{"unknown", prior.unknown},
                                        {"statistic", prior.statistic},
                                        {"dof", prior.dof},
                                        {"p_value", prior.p_value}};
                          })},
          {"findings",
           List(check.findings,
                [](const Finding& finding) {
                  return Json{{"contradicts", finding.contradicts}, {"text", Words(finding)}};
                })},
          {"p_value", check.p_value}};
}

}  // namespace dn
