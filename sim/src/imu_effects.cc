#include "imu_effects.h"

#include <dn/error.h>
#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "effects.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kRadPerArcsec = std::numbers::pi / 180.0 / 3600.0;
constexpr double kRadpsPerDegph = std::numbers::pi / 180.0 / 3600.0;
constexpr double kMps2PerMg = 1e-3 * kStandardGravityMps2;
constexpr double kMps2PerMgal = 1e-5;

Eigen::Matrix3d TurnOfTriad(const Scenario& scenario, const std::string& name) {
  return Exp(Vector3d(-1e-3 * VectorEffect(scenario, name))).toRotationMatrix();
}

std::vector<BiasProcess> ExtraProcesses(const Scenario& scenario, const std::string& name,
                                        double unit) {
  std::vector<BiasProcess> processes;
  for (const Effect* effect : EffectsNamed(scenario, name)) {
    BiasProcess process;
    process.type = BiasProcess::Type::kGaussMarkov;
    process.sigma = unit * effect->value[0];
    process.tau_s = effect->value[1];
    processes.push_back(process);
  }
  return processes;
}

template <class T>
void KeepOnly(const std::vector<bool>& keep, std::vector<T>* values) {
  std::size_t kept = 0;
  for (std::size_t k = 0; k < keep.size(); ++k) {
    if (keep[k]) (*values)[kept++] = (*values)[k];
  }
  values->resize(kept);
}

}  // namespace

ImuEffects::ImuEffects(const Scenario& scenario, std::uint64_t seed)
    : gyro_turn_(TurnOfTriad(scenario, "gyro_misalignment")),
      accel_turn_(TurnOfTriad(scenario, "accel_misalignment")),
      gyro_scale_(1e-6 * VectorEffect(scenario, "gyro_scale_factor")),
      accel_scale_(1e-6 * VectorEffect(scenario, "accel_scale_factor")),
      g_sensitivity_(kRadpsPerDegph / kStandardGravityMps2 *
                     VectorEffect(scenario, "gyro_g_sensitivity")),
      gravity_enu_(Vector3d::Zero()),
      gravity_disturbance_mps2_(kMps2PerMgal * ScalarEffect(scenario, "gravity_disturbance")),
      gyro_noise_ratio_(RatioEffect(scenario, "gyro_noise_scale")),
      accel_noise_ratio_(RatioEffect(scenario, "accel_noise_scale")),
      gyro_processes_(ExtraProcesses(scenario, "gyro_bias_process", kRadpsPerDegph)),
      accel_processes_(ExtraProcesses(scenario, "accel_bias_process", kMps2PerMg)),
      random_(seed, "imu_vibration") {
  for (const Effect* tilt : EffectsNamed(scenario, "gravity_tilt")) {
    gravity_enu_ += kRadPerArcsec * Vector3d(tilt->value[1], tilt->value[0], 0.0);
  }
  for (const Effect* vibration : EffectsNamed(scenario, "imu_vibration")) {
    vibrations_.push_back(*vibration);
  }
}

Eigen::Vector3d ImuEffects::ActualForce(const TruthState& state, const LocalFrame& frame) const {
  if (gravity_enu_.isZero(0.0) && gravity_disturbance_mps2_ == 0.0) return state.f_b;
  const Vector3d& p_m = state.pose.p_mb;
  const double g_mps2 = frame.Gravity(p_m).norm();
  const Vector3d more_enu = g_mps2 * gravity_enu_ - gravity_disturbance_mps2_ * Vector3d::UnitZ();
  return state.f_b - state.pose.q_mb.conjugate() * (frame.R_m_enu(p_m) * more_enu);
}

void ImuEffects::Distort(ImuSample* sample) const {
  const Vector3d f_true = sample->f_b_mps2;
  const Vector3d w = gyro_turn_ * sample->w_ib_b_radps;
  const Vector3d f = accel_turn_ * f_true;
  sample->w_ib_b_radps = w + gyro_scale_.cwiseProduct(w) + g_sensitivity_.cwiseProduct(f_true);
  sample->f_b_mps2 = f + accel_scale_.cwiseProduct(f);
}

void ImuEffects::Shake(ImuSample* sample) {
  for (const Effect& vibration : vibrations_) {
    if (!vibration.During(sample->t_s)) continue;
    sample->w_ib_b_radps += std::numbers::pi / 180.0 * vibration.value[0] * random_.Normal3();
    sample->f_b_mps2 += vibration.value[1] * random_.Normal3();
  }
}

void ApplyImuTagEffects(const Scenario& scenario, SimulatedImu* imu) {
  const auto gaps = EffectsNamed(scenario, "imu_gap");
  const auto steps = EffectsNamed(scenario, "imu_clock_step");
  if (gaps.empty() && steps.empty()) return;
  ImuData& data = imu->data;
  std::vector<bool> keep(data.samples.size(), true);
  for (std::size_t k = 0; k < keep.size(); ++k) {
    const double t_s = data.samples[k].t_s;
    for (const Effect* gap : gaps) keep[k] = keep[k] && !gap->During(t_s);
    for (const Effect* step : steps) {
      if (t_s >= *step->t0_s) data.samples[k].t_s += step->value[0];
    }
  }
  KeepOnly(keep, &data.samples);
  KeepOnly(keep, &imu->gyro_bias_radps);
  KeepOnly(keep, &imu->accel_bias_mps2);
  if (data.samples.empty()) {
    throw InvalidConfig("imu_gap: no inertial sample is left", gaps.front()->where);
  }
  for (std::size_t k = 1; k < data.samples.size(); ++k) {
    ImuSample& sample = data.samples[k];
    const double before_s = data.samples[k - 1].t_s;
    sample.dt_s = sample.t_s - before_s;
    if (sample.dt_s <= 0.0) {
      throw InvalidConfig("imu_clock_step: the tags would step back", steps.front()->where);
    }
    if (sample.dt_s > LongestImuInterval(data.nominal_dt_s)) sample.dt_s = data.nominal_dt_s;
  }
  CloseShortHoles(std::nullopt, &data);
}

}  // namespace dn
