#include <dn/diagnosis/gap_output.h>
#include <dn/report/wrapped.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "effect_words.h"
#include "json_numbers.h"

namespace dn {
namespace {

using diagnosis_internal::List;
using diagnosis_internal::Number;

constexpr std::size_t kMaxLimitsListed = 5;

std::string DetectionLimitLine(const DetectionLimit& effect, bool with_boresight) {
  std::string text = fmt::format("          {:<27} below {}", effect.effect,
                                 diagnosis_internal::DetectableWords(effect));
  if (effect.minimal_identifiable) {
    text +=
        ", not identifiable below " + diagnosis_internal::Rounded(*effect.minimal_identifiable, 2);
  }
  if (with_boresight) {
    text += ", boresight shift up to " + diagnosis_internal::MdegWords(effect.boresight_rad);
  }
  return text + "\n";
}

}  // namespace

Json DetectionLimitsJson(const std::vector<DetectionLimit>& effects) {
  Json list = Json::array();
  for (const DetectionLimit& effect : effects) {
    const Eigen::Vector3d damage_mdeg = diagnosis_internal::kMdegPerRad * effect.boresight_rad;
    list.push_back({{"effect", effect.effect},
                    {"minimal_detectable", Number(effect.minimal_detectable)},
                    {"detectable_by_component", List(effect.detectable_by_component)},
                    {"minimal_identifiable", Number(effect.minimal_identifiable)},
                    {"unit", effect.unit},
                    {"boresight_damage_mdeg", List(damage_mdeg)},
                    {"inseparable_from", effect.inseparable_from}});
  }
  return list;
}

std::string DetectionLimitsSummary(const std::vector<DetectionLimit>& effects,
                                   bool with_boresight) {
  if (effects.empty()) return "";
  std::vector<std::string> of_any_size;
  std::string bounded;
  std::size_t told = 0;
  for (const DetectionLimit& effect : diagnosis_internal::MostHarmful(effects)) {
    if (!std::isfinite(effect.minimal_detectable)) {
      of_any_size.push_back(effect.effect);
    } else if (told++ < kMaxLimitsListed) {
      bounded += DetectionLimitLine(effect, with_boresight);
    }
  }
  const std::string text = "undetectable effects\n";
  if (of_any_size.empty()) return text + bounded;
  return text +
         fmt::format(
             "          {}",
             WrapText(fmt::format("at any size: {}", fmt::join(of_any_size, ", ")), "          ")) +
         bounded;
}

}  // namespace dn
