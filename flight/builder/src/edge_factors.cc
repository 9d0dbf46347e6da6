#include <dn/builder/edge_factors.h>
#include <dn/builder/measurement_noise.h>
#include <dn/factors/gnss_error.h>
#include <dn/factors/gnss_position.h>
#include <dn/factors/gnss_velocity.h>
#include <dn/factors/point_to_point_between_nodes.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace dn {
namespace {

using internal::MeasurementNoise;

constexpr const char* kCheckGnss = "check its sigmas and gnss.sigma_scale";
constexpr const char* kCheckPair =
    "check its laser vectors and covariance, and the white noise of the IMU";
constexpr double kEpochRoundingS = 1e-7;

template <class Effect>
std::vector<std::shared_ptr<const Effect>> SharedEffects(const CalibrationState& state) {
  std::vector<std::shared_ptr<const Effect>> effects;
  ForEachEffect<std::shared_ptr<const Effect>>(
      state,
      [&](const auto& effect, const Eigen::VectorXd&, std::size_t) { effects.push_back(effect); });
  return effects;
}

template <class Effect>
std::vector<const double*> EffectValues(const CalibrationState& state) {
  std::vector<const double*> values;
  ForEachEffect<std::shared_ptr<const Effect>>(
      state, [&](const auto&, const Eigen::VectorXd& value, std::size_t) {
        values.push_back(value.data());
      });
  return values;
}

ImuCorrection CorrectionWith(const CalibrationState& state, const ImuCorrection& biases) {
  return state.ImuAt(biases.gyro_bias_radps, biases.accel_bias_mps2);
}

GnssEffects TimeCorrelatedErrors(const Flight& flight, const MapGnssEpoch& epoch) {
  GnssEffects errors;
  for (const GnssProcess& process : flight.config.gnss->processes) {
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

/// A pair end with the quantities that its covariance depends on.
struct PreparedEnd {
  LidarEnd end;
  Eigen::Vector3d arm_b;  // lever arm plus laser vector, body axes, m
};

PreparedEnd PrepareEnd(const Flight& flight, const PairCalibration& calibration,
                       const PreintegrationNoise& noise, double tag_s, const Eigen::Vector3d& u_s,
                       const PairEndInput& input) {
  const MapPose& node = input.node;
  const CalibrationState& state = calibration.state();
  const LidarReading reading = calibration.Read(tag_s, u_s);
  const double t_s = calibration.EmissionTime(reading);
  if (t_s < node.t_s - kEpochRoundingS) {
    throw InvalidInput("lidar time offset: the estimate of " + std::to_string(tag_s - t_s) +
                       " s exceeds the " + std::to_string(kLidarTimeMarginS) +
                       " s that can be estimated; correct the time tags of the pairs first");
  }
  PreparedEnd out;
  out.end.partial = input.partial != nullptr
                        ? *input.partial
                        : EndIncrements(*flight.imu, state, noise, node.t_s, input.biases).To(t_s);
  out.end.u_s = u_s;
  out.end.p_nominal_m = node.p_mb;
  if (input.inertial) {
    out.end.bridge = std::make_shared<IncrementConditioning>(flight.frame, out.end.partial,
                                                             input.inertial->increments());
  }
  const Eigen::Quaterniond q_boresight =
      reading.turn_b_rad.isZero(0.0)
          ? state.q_boresight
          : Exp(Eigen::Vector3d(Log(state.q_boresight) + reading.turn_b_rad));
  out.arm_b = state.lidar_lever_arm_b_m + reading.arm_b_m +
              q_boresight * (flight.config.lidar->mounting.R_bs_nominal * reading.u_s);
  return out;
}

}  // namespace

Eigen::Matrix3d GnssPositionCovariance(const MapGnssEpoch& epoch, const GnssConfig& config) {
  const Eigen::Matrix3d covariance_enu = epoch.covariance_enu_m2.value_or(
      Eigen::Matrix3d(config.sigma_enu_m.cwiseAbs2().asDiagonal()));
  return config.sigma_scale * config.sigma_scale * epoch.R_m_enu * covariance_enu *
         epoch.R_m_enu.transpose();
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

std::shared_ptr<const FactorBase> MakeGnssPositionFactor(const Flight& flight,
                                                         const MapGnssEpoch& epoch,
                                                         const CalibrationState& calibration,
                                                         const GnssEdgeInput& input) {
  const Noise<3> noise =
      MeasurementNoise(GnssPositionCovariance(epoch, *flight.config.gnss) + input.added_covariance,
                       "the GNSS position", epoch.t_s, kCheckGnss);
  GnssEffects effects = TimeCorrelatedErrors(flight, epoch);
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
  const GnssConfig& config = *flight.config.gnss;
  const Eigen::Matrix3d covariance = config.sigma_scale * config.sigma_scale * epoch.R_m_enu *
                                     *epoch.velocity_covariance_enu * epoch.R_m_enu.transpose();
  const Noise<3> noise = MeasurementNoise(covariance + input.added_covariance, "the GNSS velocity",
                                          epoch.t_s, kCheckGnss);
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

std::vector<GravitationBasis> GravitationJacobians(const CalibrationState& calibration,
                                                   const Eigen::Vector3d& p_m) {
  std::vector<GravitationBasis> bases;
  ForEachEffect<GravitationField>(
      calibration, [&](const GravitationField& field, const Eigen::VectorXd&, std::size_t) {
        bases.push_back(field(p_m));
      });
  return bases;
}

PairCalibration::PairCalibration(const CalibrationState& state)
    : state_(state), lidar_(SharedEffects<LidarEffect>(state)) {
  const std::vector<const double*> values = EffectValues<LidarEffect>(state);
  std::vector<std::shared_ptr<const LidarEffect>> not_zero;
  for (std::size_t k = 0; k < values.size(); ++k) {
    const auto past = values[k] + lidar_[k]->components();
    if (std::all_of(values[k], past, [](double value) { return value == 0.0; })) continue;
    not_zero.push_back(lidar_[k]);
    values_.push_back(values[k]);
  }
  not_zero_ = std::move(not_zero);
}

EndIncrements::EndIncrements(const ImuData& imu, const CalibrationState& calibration,
                             const PreintegrationNoise& noise, double node_t_s,
                             const ImuCorrection& biases)
    : imu_(imu),
      node_t_s_(node_t_s),
      correction_(CorrectionWith(calibration, biases)),
      growing_(imu_, node_t_s, correction_, noise) {}

Preintegrated EndIncrements::To(double epoch_s) {
  return epoch_s - node_t_s_ > kEpochRoundingS ? growing_.To(epoch_s)
                                               : IdentityIncrement(imu_, node_t_s_, correction_);
}

PairParts MakePairParts(const Flight& flight, const PairCalibration& calibration,
                        const PreintegrationNoise& noise, const PairEdgeInput& input) {
  const LidarConfig& lidar = *flight.config.lidar;
  const LidarPair& pair = input.pair;
  PreparedEnd i = PrepareEnd(flight, calibration, noise, pair.t_i_s, pair.u_i_s, input.i);
  PreparedEnd j = PrepareEnd(flight, calibration, noise, pair.t_j_s, pair.u_j_s, input.j);
  Eigen::Matrix3d covariance = pair.covariance_m2.value_or(
      Eigen::Matrix3d(lidar.sigma_p_m * lidar.sigma_p_m * Eigen::Matrix3d::Identity()));
  covariance += EndNoise(i.end, input.i.node.q_mb.toRotationMatrix(), i.arm_b);
  covariance += EndNoise(j.end, input.j.node.q_mb.toRotationMatrix(), j.arm_b);
  return {std::move(i.end),
          std::move(j.end),
          pair.t_i_s,
          pair.t_j_s,
          lidar.mounting.R_bs_nominal,
          calibration.state().lidar_time_offset_s,
          MeasurementNoise(0.5 * (covariance + covariance.transpose()), "the point pair",
                           pair.t_i_s, kCheckPair)};
}

std::shared_ptr<const FactorBase> MakePairFactor(const Flight& flight,
                                                 const PairCalibration& calibration,
                                                 const PreintegrationNoise& noise,
                                                 const PairEdgeInput& input) {
  const CalibrationState& state = calibration.state();
  const PairParts parts = MakePairParts(flight, calibration, noise, input);
  if (PairEffectIndices(state).empty() && !parts.i.bridge && !parts.j.bridge) {
    return std::make_shared<PointToPoint>(flight.frame, parts.i, parts.j, parts.T_bs_nominal,
                                          parts.dt_nominal_s, parts.noise_m);
  }
  return std::make_shared<PointToPointBetweenNodes>(
      flight.frame, parts.i, parts.j, parts.tag_i_s, parts.tag_j_s, parts.T_bs_nominal,
      calibration.lidar(), GravitationJacobians(state, input.i.node.p_mb), parts.noise_m);
}

}  // namespace dn
