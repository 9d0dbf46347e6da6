#include <dn/builder/estimable.h>
#include <dn/names.h>

#include <algorithm>

namespace dn {

std::vector<std::string> EstimableEffects() {
  return {"gnss_lever_arm", "lidar_lever_arm", "lidar_time_offset", "gyro_scale_factor"};
}

void CheckEstimable(const std::vector<EstimateEntry>& estimate) {
  const std::vector<std::string> estimable = EstimableEffects();
  for (const EstimateEntry& entry : estimate) {
    if (entry.unknown == "boresight") continue;
    if (std::find(estimable.begin(), estimable.end(), entry.unknown) != estimable.end()) continue;
    throw InvalidConfig("estimate: '" + entry.unknown +
                            "' is an effect, but not estimable by this version; estimable are "
                            "boresight, " +
                            JoinNames(estimable),
                        entry.where);
  }
}

}  // namespace dn
