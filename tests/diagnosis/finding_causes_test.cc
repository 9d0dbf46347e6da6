#include "finding_causes.h"

#include <gmock/gmock.h>

#include <string>
#include <vector>

namespace dn::diagnosis_internal {
namespace {

Finding Larger(const std::string& group, bool contradicts = true) {
  facts::VarianceTooLarge fact;
  fact.group.name = group;
  return {fact, contradicts, 1.0};
}

Finding Shared(const std::string& group, bool contradicts = true) {
  facts::ErrorsShared fact;
  fact.common.group = group;
  return {fact, contradicts, 1.0};
}

Finding Present(const std::string& effect) {
  facts::EffectPresent fact;
  fact.effect.name = effect;
  return {fact, true, 1.0};
}

/// Returns the findings by the index of their type and the group or the effect that they name.
std::vector<std::string> Sorted(std::vector<Finding> findings) {
  SortByCause(&findings);
  std::vector<std::string> names;
  for (const Finding& finding : findings) {
    if (const auto* one = finding.As<facts::VarianceTooLarge>()) names.push_back(one->group.name);
    if (const auto* one = finding.As<facts::ErrorsShared>()) {
      names.push_back("shared " + one->common.group);
    }
    if (const auto* one = finding.As<facts::EffectPresent>()) names.push_back(one->effect.name);
    if (finding.As<facts::UpsideDown>() != nullptr) names.emplace_back("upside down");
  }
  return names;
}

using ::testing::ElementsAre;

TEST(SortByCause, EveryCauseIsNamedBeforeItIsRepeated) {
  EXPECT_THAT(Sorted({Larger("gnss velocity"), Larger("gnss velocity east"),
                      Shared("gnss position"), Larger("inertial gyro z"), Shared("gyro bias"),
                      Larger("inertial velocity"), Larger("lidar p2p")}),
              ElementsAre("gnss velocity", "inertial gyro z", "inertial velocity", "lidar p2p",
                          "gnss velocity east", "shared gnss position", "shared gyro bias"));
}

TEST(SortByCause, WrongAxesAndClocksComeFirst) {
  EXPECT_THAT(Sorted({Larger("gnss velocity"),
                      Present("gnss_lever_arm"),
                      Present("gnss_time_offset"),
                      {facts::UpsideDown{}, true, 1.0}}),
              ElementsAre("upside down", "gnss_time_offset", "gnss velocity", "gnss_lever_arm"));
  EXPECT_THAT(
      Sorted({Larger("gnss velocity"), Present("gnss_time_drift"), Present("gnss_time_offset")}),
      ElementsAre("gnss_time_drift", "gnss velocity", "gnss_time_offset"));
}

TEST(SortByCause, WhatContradictsStaysBeforeWhatDoesNot) {
  EXPECT_THAT(
      Sorted({Larger("gnss velocity"), Larger("gnss position"), Larger("inertial velocity", false),
              Shared("lidar p2p", false)}),
      ElementsAre("gnss velocity", "gnss position", "inertial velocity", "shared lidar p2p"));
}

}  // namespace
}  // namespace dn::diagnosis_internal
