#include <dn/imu/unknown_imu.h>

#include "config_sections.h"

namespace dn {
namespace files_internal {

UnmodelledConfig ReadUnmodelled(const YamlValue& section) {
  UnmodelledConfig config;
  if (section.IsScalar()) {
    config.none = section.Choice(std::vector<std::pair<std::string, bool>>{{"none", true}});
    return config;
  }
  section.ExpectMap(EffectNames(EffectKind::kFixed));
  for (const std::string& name : section.Keys()) {
    const YamlValue value = section[name];
    const EffectSpec& effect = *FindEffect(name);
    if (effect.timing == EffectTiming::kWindow) {
      value.Fail(
          "takes fixed effects alone; the model states random errors where their sensor is, and "
          "`estimate` takes errors that act for a part of the flight");
    }
    config.sizes.push_back({effect.id, ReadEffectSigma(value, effect, &ReadNotNegative)});
  }
  return config;
}

}  // namespace files_internal

namespace {

SensorClass FindClass(const std::optional<ImuConfig>& imu) {
  if (!imu) return SensorClass::kNavigation;
  const bool data_sheet = imu->grade && *imu->grade != kUnknownGrade;
  return data_sheet ? ClassByDataSheet(ImuPreset(*imu->grade).gyro.white)
                    : ClassInFlight(imu->model.gyro.white);
}

}  // namespace

bool HasAutomaticGnssProcess(const FlightConfig& config) {
  return !config.unmodelled.none && config.gnss && config.gnss->automatic_process &&
         config.gnss->processes.empty();
}

UnmodelledPrior MakeUnmodelledPrior(const FlightConfig& config) {
  if (config.unmodelled.none) return {};
  UnmodelledPrior prior(FindClass(config.imu));
  for (const auto& [effect, sigma] : config.unmodelled.sizes) {
    prior.Set(effect, files_internal::EffectSigmaInSi(EffectRow(effect), sigma));
  }
  return prior;
}

}  // namespace dn
