#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/files/across.h>
#include <dn/geo/text_table.h>
#include <dn/names.h>

#include <numbers>

namespace dn {
namespace {

const char* const kShared = "boresight";
const char* const kWalk = "random_walk_deg";
constexpr std::size_t kMostShared = 100;
constexpr double kRadPerDegree = std::numbers::pi / 180.0;

std::string ReadShared(const YamlValue& value) {
  std::string name = ReadName(value);
  if (name == kShared) return name;
  const EffectSpec* effect = FindEffect(name);
  if (effect == nullptr || effect->name != name) {
    std::vector<std::string> known = EffectNames(EffectKind::kFixed);
    known.emplace_back(kShared);
    value.Fail("unknown name '" + name + "'; did you mean '" + NearestName(name, known) + "'?");
  }
  if (!effect->fixed() || effect->timing != EffectTiming::kFlight) {
    value.Fail("'" + name + "' is not a constant that several flights can share");
  }
  return name;
}

void ReadWalk(const YamlValue& value, AcrossConfig* across) {
  if (!value) return;
  across->walk_estimated = value.IsScalar() && value.Text() == "estimate";
  if (!across->walk_estimated) across->walk_rad = kRadPerDegree * ReadPositive(value);
}

}  // namespace

AcrossConfig ParseAcross(const YamlValue& section) {
  AcrossConfig across;
  if (!section) return across;
  bool boresight = false;
  for (const YamlValue& item : section.Items(kMostShared)) {
    if (item.IsMap()) item.ExpectMap({"unknown", kWalk});
    const YamlValue name = item.IsMap() ? item["unknown"] : item;
    const std::string unknown = ReadShared(name);
    if ((unknown == kShared && boresight) || HasName(across.unknowns, unknown)) {
      item.Fail("'" + unknown + "' is given twice");
    }
    if (unknown == kShared) {
      boresight = true;
      if (item.IsMap()) ReadWalk(item[kWalk], &across);
      continue;
    }
    if (item.IsMap() && item[kWalk]) {
      item[kWalk].Fail("does not belong to '" + unknown + "': only the boresight may change");
    }
    across.unknowns.push_back(unknown);
  }
  if (!boresight) section.Fail("'boresight' is missing: it is what all flights share");
  return across;
}

std::string FormatAcross(const AcrossConfig& across) {
  std::string text = kShared;
  if (across.walk_estimated) text = "{unknown: boresight, random_walk_deg: estimate}";
  if (across.walk_rad) {
    text =
        "{unknown: boresight, random_walk_deg: " + FormatDouble(*across.walk_rad / kRadPerDegree) +
        "}";
  }
  for (const std::string& unknown : across.unknowns) text += ", " + unknown;
  return "[" + text + "]";
}

}  // namespace dn
