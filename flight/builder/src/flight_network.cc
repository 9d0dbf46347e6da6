#include <dn/builder/flight_network.h>
#include <dn/builder/node_grid.h>
#include <dn/error.h>

#include <string>

#include "effect_values.h"

namespace dn {
namespace {

PreintegrationNoise IncrementNoise(const ImuModel& model, double position_floor_m) {
  return {model.gyro.white, model.accel.white, position_floor_m, model.vibration};
}

}  // namespace

FlightNetwork::Parts::Parts(const Flight& flight, const std::vector<double>& node_t_s,
                            const InitialStates& initial, const FlightNetworkOptions& options)
    : calibration(flight, initial.calibration ? *initial.calibration : AssumedCalibration(flight),
                  &net),
      trajectory(
          flight, node_t_s, initial,
          {options.bias_interval_per_tau, options.bias_interval_max_s, options.process_model},
          &net),
      factors(&net),
      context{flight,         calibration,
              trajectory,     net,
              factors,        IncrementNoise(flight.config.imu->model, options.position_floor_m),
              options.threads},
      inertial(context),
      gnss(context),
      pairs(context, inertial),
      control(context, inertial, &net, ControlEdges::Kind::kControl),
      ties(context, inertial, &net, ControlEdges::Kind::kTies),
      surfaces(context, inertial, &net, ControlEdges::Kind::kSurfaces) {}

FlightNetwork::FlightNetwork(const Flight& flight, const std::vector<double>& node_t_s,
                             const InitialStates& initial, const FlightNetworkOptions& options)
    : make_pair_model_(options.pair_model),
      parts_(std::make_unique<Parts>(flight, node_t_s, initial, options)) {}

void FlightNetwork::AddPairs(const std::vector<LidarPair>& pairs) {
  if (make_pair_model_ && !parts_->pairs.has_model()) {
    parts_->pairs.SetModel(make_pair_model_(*this));
  }
  parts_->pairs.Add(pairs);
}

void FlightNetwork::Repreintegrate() {
  const CalibrationState now = parts_->calibration.State();
  parts_->inertial.Repreintegrate(now);
  parts_->gnss.Rebuild(now);
  parts_->pairs.Repreintegrate(now);
  parts_->control.Repreintegrate(now);
  parts_->ties.Repreintegrate(now);
  parts_->surfaces.Repreintegrate(now);
}

FlightNetwork::StateBetween FlightNetwork::StateAt(double t_s) const {
  constexpr double kSameNodeS = 1e-7;
  const std::vector<double>& node_t_s = trajectory().node_times();
  if (t_s < node_t_s.front() - kSameNodeS || t_s > node_t_s.back() + kSameNodeS) {
    throw InvalidInput("flight network: t = " + std::to_string(t_s) + " s is outside its nodes, " +
                       std::to_string(node_t_s.front()) + " to " + std::to_string(node_t_s.back()) +
                       " s");
  }
  const std::size_t k = NodeBefore(node_t_s, t_s + kSameNodeS);
  const ImuCorrection correction =
      builder_internal::CorrectionWith(calibration().State(), trajectory().BiasesAt(node_t_s[k]));
  const Preintegrated increments =
      t_s - node_t_s[k] > kSameNodeS
          ? Preintegrate(*flight().imu, node_t_s[k], t_s, correction, parts_->context.noise)
          : IdentityIncrement(*flight().imu, node_t_s[k], correction);
  return {k, StateAfterNode(flight().frame, increments, trajectory().NodePose(k).p_mb), increments};
}

}  // namespace dn
