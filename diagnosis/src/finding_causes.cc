#include "finding_causes.h"

#include <dn/effects/effect_table.h>

#include <algorithm>
#include <map>
#include <string>
#include <tuple>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

constexpr const char* kAxesCause = "axes";
constexpr const char* kClockCause = "GNSS clock";
constexpr const char* kAntennaCause = "antenna";

/// Returns the sensor whose noise a group of residuals belongs to.
std::string NoiseCause(const std::string& group) {
  if (group.starts_with("gyro") || group.starts_with("inertial gyro")) return "noise of gyros";
  if (group.starts_with("accel") || group.starts_with("inertial")) return "noise of accelerometers";
  return "noise of " + group.substr(0, group.find(' '));
}

std::string EffectCause(const std::string& effect) {
  const bool clock =
      IsEffect(effect, EffectId::kGnssTimeOffset) || IsEffect(effect, EffectId::kGnssTimeDrift);
  if (clock) return kClockCause;
  return IsEffect(effect, EffectId::kGnssLeverArm) ? kAntennaCause : effect;
}

/// Returns a name of what a finding indicates. Findings of one cause have the same name.
std::string Cause(const Finding& finding) {
  if (const auto* fact = finding.As<facts::EffectPresent>()) return EffectCause(fact->effect.name);
  if (const auto* fact = finding.As<facts::VarianceTooLarge>()) return NoiseCause(fact->group.name);
  if (const auto* fact = finding.As<facts::ErrorsShared>()) return NoiseCause(fact->common.group);
  if (finding.As<facts::GnssTimeOff>()) return kClockCause;
  if (finding.As<facts::GnssLeverArmOff>()) return kAntennaCause;
  if (finding.As<facts::UpsideDown>() || finding.As<facts::MountingImpossible>()) return kAxesCause;
  return std::to_string(finding.fact.index());
}

int Rank(const std::string& cause) {
  if (cause == kAxesCause) return 0;
  return cause == kClockCause ? 1 : 2;
}

struct Place {
  bool follows = false;  // a finding of the same cause comes before
  int rank = 0;
};

std::vector<Place> FindPlaces(const std::vector<Finding>& findings) {
  std::map<std::pair<bool, std::string>, int> seen;
  std::vector<Place> places;
  for (const Finding& finding : findings) {
    const std::string cause = Cause(finding);
    places.push_back({seen[{finding.contradicts, cause}]++ > 0, Rank(cause)});
  }
  return places;
}

}  // namespace

void SortByCause(std::vector<Finding>* findings) {
  const std::vector<Place> places = FindPlaces(*findings);
  std::vector<std::size_t> order(findings->size());
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = k;
  const auto key = [&](std::size_t k) {
    return std::tuple(!(*findings)[k].contradicts, places[k].follows, places[k].rank);
  };
  std::ranges::stable_sort(order, {}, key);
  std::vector<Finding> sorted;
  for (const std::size_t k : order) sorted.push_back(std::move((*findings)[k]));
  *findings = std::move(sorted);
}

}  // namespace dn::diagnosis_internal
