#include "open_filter.h"

#include <dn/builder/flight_network.h>
#include <dn/builder/gnss_factors.h>
#include <dn/builder/node_grid.h>
#include <dn/navigation/alignment.h>
#include <dn/rotation.h>

#include <algorithm>

namespace dn::adjustment_internal {
namespace {

/// Returns the flight with GNSS tags corrected by the calibration, and removes the clock effects
/// from the calibration. Returns nullopt if it has no clock effects.
std::optional<Flight> CorrectGnssTags(const Flight& flight, CalibrationState* calibration) {
  const auto of_clock = [&](const CalibrationValue& effect) {
    return IsEffect(effect.name, EffectId::kGnssTimeOffset) ||
           IsEffect(effect.name, EffectId::kGnssTimeDrift);
  };
  auto& effects = calibration->effects;
  if (std::none_of(effects.begin(), effects.end(), of_clock)) return std::nullopt;
  Flight corrected = flight;
  for (MapGnssEpoch& epoch : corrected.gnss->epochs) {
    epoch.t_s = GnssEpochTime(*calibration, epoch.t_s);
  }
  std::erase_if(effects, of_clock);
  return corrected;
}

/// Adds the variance that random walks have gained by the end of the flight; their prior holds at
/// its beginning.
void AddRandomWalkVariance(const ImuModel& model, double duration_s, FilterState* state) {
  constexpr Eigen::Index kFirstProcess = 9;
  Eigen::Index row = kFirstProcess;
  for (const auto* processes : {&model.gyro.processes, &model.accel.processes}) {
    for (const BiasProcess& process : *processes) {
      if (process.type == BiasProcess::Type::kRandomWalk) {
        state->covariance.diagonal().segment<3>(row).array() +=
            process.sigma * process.sigma * duration_s;
      }
      row += 3;
    }
  }
}

}  // namespace

Eigen::Vector3d DiffuseAttitudeSigma() {
  return {2.0 * kRadPerDeg, 2.0 * kRadPerDeg, 5.0 * kRadPerDeg};
}

DiffusePriorFilter::DiffusePriorFilter(const Adjustment& adjustment)
    : network_(*adjustment.network) {
  CalibrationState calibration = network_.calibration().State();
  at_epochs_ = CorrectGnssTags(network_.flight(), &calibration);
  options_.skipped_epochs = adjustment.gnss_rejected;
  options_.calibration = calibration;
  const TimeInterval span = NetworkSpan(flight(), false);
  times_ = NodeTimes(*flight().imu, span, GnssTimes(flight(), span), {}, {});
}

FilterState DiffusePriorFilter::StartAt(double t_s) const {
  const std::size_t k = NodeBefore(network_.trajectory().node_times(), t_s + 1e-6);
  return MakeFilterState(flight(), network_.trajectory().NodePose(k),
                         network_.trajectory().GyroBias(t_s), network_.trajectory().AccelBias(t_s),
                         DiffuseAttitudeSigma(), 3.0 * TypicalGnssSigma(flight()), 1.0);
}

DirectedRun DiffusePriorFilter::Run(FilterDirection direction) const {
  const bool reverse = direction == FilterDirection::kReverse;
  FilterState start = StartAt(reverse ? times_.back() : times_.front());
  if (reverse) {
    AddRandomWalkVariance(flight().config.imu->model, times_.back() - times_.front(), &start);
  }
  return RunFilter(flight(), times_, start, direction, options_);
}

}  // namespace dn::adjustment_internal
