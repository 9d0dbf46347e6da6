#include <dn/builder/gnss_factors.h>
#include <dn/builder/gnss_multipath.h>
#include <dn/builder/measurement_noise.h>
#include <dn/factors/gnss_error.h>
#include <dn/factors/gnss_position.h>
#include <dn/factors/gnss_velocity.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "effect_values.h"

namespace dn {
namespace {

using builder_internal::CorrectionWith;
using builder_internal::EffectValues;
using builder_internal::MeasurementNoise;
using builder_internal::SharedEffects;

constexpr const char* kCheckGnss = "check its sigmas and gnss.sigma_scale";

GnssEffects TimeCorrelatedErrors(const Flight& flight, const MapGnssEpoch& epoch,
                                 const MapPose& pose) {
  GnssEffects errors;
  for (GnssProcess process : flight.config.gnss->processes) {
    process.sigma_enu_m = GnssProcessSigma(process, pose, epoch.R_m_enu.col(2));
    errors.push_back(std::make_shared<CorrelatedGnssError>(process, epoch.R_m_enu));
  }
  return errors;
}

MotionNearTag MotionAtEpoch(const Flight& flight, const MapGnssEpoch& epoch,
                            const CalibrationState& state, const GnssEdgeInput& input,
                            const Preintegrated& here) {
  const Eigen::Vector3d w_ie_m = flight.frame.w_ie_m();
  const MapPose& pose = input.pose;
  const Eigen::Vector3d a_m = pose.q_mb * here.f_end_b_mps2 + flight.frame.Gravity(pose.p_mb) +
                              state.GravitationAt(pose.p_mb) - 2.0 * w_ie_m.cross(pose.v_m);
  return {epoch.t_s, here.w_end_b_radps, w_ie_m, a_m, epoch.t_s - pose.t_s};
}

}  // namespace

Eigen::Matrix3d GnssPositionCovariance(const MapGnssEpoch& epoch, const GnssConfig& config) {
  const Eigen::Matrix3d covariance_enu = epoch.covariance_enu_m2.value_or(
      Eigen::Matrix3d(config.sigma_enu_m.cwiseAbs2().asDiagonal()));
  return config.sigma_scale * config.sigma_scale * epoch.R_m_enu * covariance_enu *
         epoch.R_m_enu.transpose();
}

Eigen::Matrix3d GnssVelocityCovariance(const MapGnssEpoch& epoch, const GnssConfig& config) {
  const double scale = config.velocity_sigma_scale.value_or(config.sigma_scale);
  return scale * scale * epoch.R_m_enu * *epoch.velocity_covariance_enu * epoch.R_m_enu.transpose();
}

std::vector<BiasProcess> GnssProcessesInSigmas(const GnssConfig& config) {
  std::vector<BiasProcess> processes;
  for (const GnssProcess& process : config.processes) {
    processes.push_back({BiasProcess::Type::kGaussMarkov, 1.0, process.tau_s});
  }
  return processes;
}

double TypicalGnssSigma(const Flight& flight) {
  const GnssConfig& config = *flight.config.gnss;
  Eigen::Vector3d variance = GnssPositionCovariance(flight.gnss->epochs.front(), config).diagonal();
  for (const GnssProcess& process : config.processes) variance += process.sigma_enu_m.cwiseAbs2();
  return std::sqrt(variance.maxCoeff());
}

double GnssEpochTime(const CalibrationState& calibration, double tag_s) {
  const std::vector<const double*> values = EffectValues<GnssEffect>(calibration);
  return tag_s - Corrected(SharedEffects<GnssEffect>(calibration), values.data(), tag_s).delay_s;
}

bool UsesVelocity(const MapGnssEpoch& epoch, const GnssConfig& config) {
  return config.use_velocity.value_or(true) && epoch.velocity_enu_mps.has_value() &&
         epoch.velocity_covariance_enu.has_value();
}

bool UsesVelocities(const Flight& flight) {
  return std::ranges::any_of(flight.gnss->epochs, [&](const MapGnssEpoch& epoch) {
    return UsesVelocity(epoch, *flight.config.gnss);
  });
}

std::shared_ptr<const FactorBase> MakeGnssPositionFactor(const Flight& flight,
                                                         const MapGnssEpoch& epoch,
                                                         const CalibrationState& calibration,
                                                         const GnssEdgeInput& input) {
  const Noise<3> noise =
      MeasurementNoise(GnssPositionCovariance(epoch, *flight.config.gnss) + input.added_covariance,
                       "the GNSS position", epoch.t_s, kCheckGnss);
  GnssEffects effects = TimeCorrelatedErrors(flight, epoch, input.pose);
  for (auto& effect : SharedEffects<GnssEffect>(calibration)) effects.push_back(std::move(effect));
  if (effects.empty()) return std::make_shared<GnssPosition>(epoch.p_m, noise);
  const Preintegrated here =
      IdentityIncrement(*flight.imu, input.pose.t_s, CorrectionWith(calibration, input.biases));
  return std::make_shared<GnssAntenna>(GnssAntenna::Quantity::kPosition, epoch.p_m,
                                       MotionAtEpoch(flight, epoch, calibration, input, here),
                                       std::move(effects), noise);
}

std::shared_ptr<const FactorBase> MakeGnssVelocityFactor(const Flight& flight,
                                                         const MapGnssEpoch& epoch,
                                                         const CalibrationState& calibration,
                                                         const GnssEdgeInput& input) {
  const Noise<3> noise =
      MeasurementNoise(GnssVelocityCovariance(epoch, *flight.config.gnss) + input.added_covariance,
                       "the GNSS velocity", epoch.t_s, kCheckGnss);
  const Eigen::Vector3d z_m = epoch.R_m_enu * *epoch.velocity_enu_mps;
  const Preintegrated here =
      IdentityIncrement(*flight.imu, input.pose.t_s, CorrectionWith(calibration, input.biases));
  GnssEffects effects = SharedEffects<GnssEffect>(calibration);
  if (effects.empty()) {
    return std::make_shared<GnssVelocity>(z_m, here.w_end_b_radps, flight.frame.w_ie_m(), noise);
  }
  return std::make_shared<GnssAntenna>(GnssAntenna::Quantity::kVelocity, z_m,
                                       MotionAtEpoch(flight, epoch, calibration, input, here),
                                       std::move(effects), noise);
}

}  // namespace dn
