#include "imu_tags.h"

#include <dn/error.h>

#include <optional>

namespace dn {
namespace {

template <class T>
void KeepOnly(const std::vector<bool>& keep, std::vector<T>* values) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < keep.size(); ++k) {
    if (keep[k]) (*values)[kept++] = (*values)[k];
  }
  values->resize(kept);
}

void LeaveOutGaps(const ActiveEffects& effects, SimulatedImu* imu) {
  std::vector<bool> keep;
  for (const ImuSample& sample : imu->data.samples) {
    keep.push_back(!InGap(effects.imu_gaps, sample.t_s));
  }
  KeepOnly(keep, &imu->data.samples);
  KeepOnly(keep, &imu->gyro_bias_radps);
  KeepOnly(keep, &imu->accel_bias_mps2);
  if (imu->data.samples.empty()) {
    const DataGap& gap = effects.imu_gaps.front();
    throw InvalidConfig(gap.effect + ": no inertial sample remains", gap.where);
  }
}

}  // namespace

void ApplyImuTagEffects(const ActiveEffects& effects, SimulatedImu* imu) {
  if (effects.imu_gaps.empty() && effects.imu_tags.empty()) return;
  LeaveOutGaps(effects, imu);
  ImuData& data = imu->data;
  double before_s = data.samples.front().t_s;
  data.samples.front().t_s = Tag(effects.imu_tags, before_s);
  for (std::size_t k = 1; k < data.samples.size(); ++k) {
    ImuSample& sample = data.samples[k];
    const double t_s = sample.t_s;
    sample.t_s = Tag(effects.imu_tags, t_s);
    sample.dt_s = sample.t_s - data.samples[k - 1].t_s;
    if (sample.dt_s <= 0.0) RefuseStepBack(effects.imu_tags, before_s, t_s);
    if (sample.dt_s > LongestImuInterval(data.nominal_dt_s)) sample.dt_s = data.nominal_dt_s;
    before_s = t_s;
  }
  CloseShortHoles(std::nullopt, &data);
}

}  // namespace dn
