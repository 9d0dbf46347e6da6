#include <dn/names.h>

#include <algorithm>

#include "config_sections.h"

namespace dn {
namespace files_internal {
namespace {

const char* const kBoresight = "boresight";
constexpr std::size_t kMostEntries = 1000;

const EffectSpec& FixedEffect(const YamlValue& value, const std::string& name) {
  const EffectSpec* effect = FindEffect(name);
  if (effect == nullptr || effect->name != name) {
    std::vector<std::string> known = EffectNames(EffectKind::kFixed);
    known.emplace_back(kBoresight);
    value.Fail("unknown name '" + name + "'; did you mean '" + NearestName(name, known) + "'?");
  }
  if (effect->random()) {
    value.Fail(
        "'" + name +
        "' is random and cannot be estimated as an unknown; state it in the noise of its sensor");
  }
  if (effect->kind == EffectKind::kFault) {
    value.Fail("'" + name + "' is a fault of the data and cannot be estimated as an unknown");
  }
  return *effect;
}

void ReadWord(const YamlValue& item, EstimateEntry* entry) {
  entry->unknown = ReadName(item);
  if (entry->unknown == kBoresight) return;
  const std::string key = TimingKey(FixedEffect(item, entry->unknown).timing);
  if (!key.empty()) {
    item.Fail("'" + entry->unknown + "' needs " + key + ": {unknown: " + entry->unknown + ", " +
              key + ": ...}");
  }
}

void ReadMap(const YamlValue& item, EstimateEntry* entry) {
  item.ExpectMap({"unknown", "scanner", "sigma", "window_s", "t0_s"});
  if (item["scanner"]) entry->scanner = ReadName(item["scanner"]);
  entry->unknown = ReadName(item["unknown"]);
  if (entry->unknown == kBoresight) {
    if (item["sigma"]) {
      item["sigma"].Fail("the prior of the boresight is lidar.boresight_sigma_deg");
    }
    for (const char* key : {"window_s", "t0_s"}) {
      if (item[key]) item[key].Fail("does not belong to 'boresight'");
    }
    return;
  }
  const EffectSpec& effect = FixedEffect(item["unknown"], entry->unknown);
  entry->times = ReadEffectTimes(item, effect);
  if (item["sigma"]) entry->sigma = ReadEffectSigma(item["sigma"], effect, &ReadPositive);
}

}  // namespace

std::vector<double> ReadEffectSigma(const YamlValue& value, const EffectSpec& effect,
                                    double (*read)(const YamlValue&)) {
  std::vector<double> sigma;
  for (const YamlValue& item : value.Items()) sigma.push_back(read(item));
  const std::size_t count = effect.components.size();
  if (sigma.size() != 1 && sigma.size() != count) {
    value.Fail("'" + effect.name + "' takes one number" +
               (count == 1 ? "" : " or " + std::to_string(count)) + ", in " +
               effect.components.front().unit);
  }
  return sigma;
}

Eigen::VectorXd EffectSigmaInSi(const EffectSpec& effect, const std::vector<double>& sigma) {
  const std::size_t count = effect.components.size();
  return ValueInSi(effect, sigma.size() == 1 ? std::vector<double>(count, sigma.front()) : sigma);
}

std::vector<EstimateEntry> ReadEstimate(const YamlValue& section) {
  std::vector<EstimateEntry> entries;
  for (const YamlValue& item : section.Items(kMostEntries)) {
    EstimateEntry entry;
    entry.where = item.where();
    item.IsMap() ? ReadMap(item, &entry) : ReadWord(item, &entry);
    const auto same = [&](const EstimateEntry& e) {
      return e.unknown == entry.unknown && e.scanner == entry.scanner;
    };
    if (std::any_of(entries.begin(), entries.end(), same)) {
      item.Fail("'" + entry.unknown + "' is given twice");
    }
    entries.push_back(std::move(entry));
  }
  return entries;
}

}  // namespace files_internal

bool IsBoresight(const EstimateEntry& entry) {
  return entry.unknown.substr(0, entry.unknown.find('/')) == files_internal::kBoresight;
}

std::optional<Eigen::VectorXd> PriorSigma(const EstimateEntry& entry) {
  if (entry.sigma.empty()) return std::nullopt;
  const EffectSpec* effect = FindEffect(entry.unknown);
  if (effect == nullptr || effect->kind != EffectKind::kFixed) {
    throw InvalidInput("estimate: '" + entry.unknown + "' is not a fixed effect", entry.where);
  }
  const std::size_t count = effect->components.size();
  if (entry.sigma.size() != 1 && entry.sigma.size() != count) {
    throw InvalidInput("estimate: " + std::to_string(entry.sigma.size()) + " sigmas for the " +
                           std::to_string(count) + " components of '" + entry.unknown + "'",
                       entry.where);
  }
  return files_internal::EffectSigmaInSi(*effect, entry.sigma);
}

}  // namespace dn
