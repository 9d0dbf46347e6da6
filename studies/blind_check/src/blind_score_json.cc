#include <dn/blind_check/blind_score.h>

namespace dn {
namespace {

Json ToJson(const Share& share) {
  const Interval interval = share.interval_95();
  return {{"hits", share.hits},
          {"of", share.of},
          {"share", share.value()},
          {"interval_95", {interval.low, interval.high}}};
}

Json ToJson(const Quartiles& q) {
  return {{"count", q.count}, {"low", q.low}, {"median", q.median}, {"high", q.high}};
}

Json ToJson(const std::vector<CalibrationScore>& scores) {
  Json rows = Json::array();
  for (const CalibrationScore& score : scores) {
    rows.push_back({{"verdict", score.verdict},
                    {"flights", score.flights},
                    {"beyond_5_sigma", score.beyond_5_sigma},
                    {"rms_sigmas", score.rms_sigmas}});
  }
  return rows;
}

Json ToJson(const std::vector<AverageScore>& scores) {
  Json rows = Json::array();
  for (const AverageScore& score : scores) {
    rows.push_back({{"verdict", score.verdict},
                    {"in_region_95", ToJson(score.in_region_95)},
                    {"angles_95", ToJson(score.angles_95)}});
  }
  return rows;
}

Json ToJson(const std::vector<VerdictCount>& counts) {
  Json rows = Json::array();
  for (const VerdictCount& count : counts) {
    rows.push_back(
        {{"content", Word(count.content)}, {"verdict", count.verdict}, {"flights", count.flights}});
  }
  return rows;
}

Json ToJson(const std::vector<EffectScore>& effects) {
  Json rows = Json::array();
  for (const EffectScore& score : effects) {
    rows.push_back({{"effect", score.effect},
                    {"detected", ToJson(score.detected)},
                    {"named", ToJson(score.named)},
                    {"named_with_group", ToJson(score.named_with_group)}});
  }
  return rows;
}

Json ToJson(const std::array<SizeScore, 3>& sizes) {
  Json rows = Json::array();
  for (const SizeScore& score : sizes) {
    rows.push_back({{"from", score.from},
                    {"detected", ToJson(score.detected)},
                    {"named", ToJson(score.named)},
                    {"named_with_group", ToJson(score.named_with_group)}});
  }
  return rows;
}

Json ToJson(const std::vector<UnlistedEffectScore>& outsiders) {
  Json rows = Json::array();
  for (const UnlistedEffectScore& score : outsiders) {
    rows.push_back({{"outsider", score.outsider},
                    {"detected", ToJson(score.detected)},
                    {"rejected", ToJson(score.rejected)}});
  }
  return rows;
}

Json ToJson(const std::array<StrengthScore, 4>& strengths) {
  Json rows = Json::array();
  for (const StrengthScore& score : strengths) {
    rows.push_back({{"from_sigmas", score.from_sigmas},
                    {"detected", ToJson(score.detected)},
                    {"named", ToJson(score.named)},
                    {"named_with_group", ToJson(score.named_with_group)},
                    {"calibrated_beyond_5_sigma", ToJson(score.calibrated_beyond_5_sigma)}});
  }
  return rows;
}

Json ToJson(const std::array<SignatureScore, 3>& signatures) {
  Json rows = Json::array();
  for (const SignatureScore& score : signatures) {
    rows.push_back({{"from_sigmas", score.from_sigmas},
                    {"detected", ToJson(score.detected)},
                    {"rejected_of_detected", ToJson(score.rejected)},
                    {"misnamed_of_detected", ToJson(score.misnamed)}});
  }
  return rows;
}

Json ToJson(const std::array<ReliabilityBin, 10>& bins) {
  Json rows = Json::array();
  for (const ReliabilityBin& bin : bins) {
    rows.push_back({{"low", bin.low},
                    {"high", bin.high},
                    {"stated", bin.stated},
                    {"true", ToJson(bin.true_causes)}});
  }
  return rows;
}

Json ToJson(const SeveralScore& score) {
  return {{"detected", ToJson(score.detected)},
          {"named", ToJson(score.named)},
          {"named_with_group", ToJson(score.named_with_group)},
          {"members", ToJson(score.members)}};
}

}  // namespace

Json ToJson(const BlindScore& s) {
  return {{"schema", "dn.blind_check/1"},
          {"flights", s.flights},
          {"failures", s.failures},
          {"nothing",
           {{"false_alarms", ToJson(s.false_alarms)},
            {"allowed_95", {s.alarms_allowed.low, s.alarms_allowed.high}},
            {"false_names", ToJson(s.false_names)},
            {"p_value", ToJson(s.null_p_value)},
            {"uniformity_p", s.null_uniformity_p}}},
          {"verdicts", ToJson(s.verdicts)},
          {"one_effect",
           {{"detected", ToJson(s.one_detected)},
            {"named", ToJson(s.one_named)},
            {"named_with_group", ToJson(s.one_named_with_group)},
            {"posterior_of_the_truth", ToJson(s.truth_posterior)}}},
          {"two_effects", ToJson(s.two)},
          {"three_effects", ToJson(s.three)},
          {"spurious_names", s.spurious},
          {"outsider",
           {{"detected", ToJson(s.outsider_detected)},
            {"rejected_of_detected", ToJson(s.outsider_rejected)},
            {"misnamed_of_detected", ToJson(s.outsider_misnamed)}}},
          {"by_size", ToJson(s.sizes)},
          {"by_strength", ToJson(s.strengths)},
          {"by_effect", ToJson(s.effects)},
          {"by_outsider", ToJson(s.outsiders)},
          {"by_signature", ToJson(s.signatures)},
          {"reliability", ToJson(s.reliability)},
          {"coverage_95",
           {{"fixed", ToJson(s.fixed_coverage)}, {"stochastic", ToJson(s.stochastic_coverage)}}},
          {"boresight",
           {{"assumed", ToJson(s.calibrated)},
            {"adapted", ToJson(s.adapted)},
            {"averaged", ToJson(s.averaged)}}},
          {"shrinkage",
           {{"right_name", ToJson(s.shrinkage_right)}, {"wrong_name", ToJson(s.shrinkage_wrong)}}}};
}

}  // namespace dn
