#pragma once

#include <dn/imu/imu_data.h>
#include <dn/sim/scenario.h>
#include <dn/sim/truth.h>

#include <functional>
#include <optional>

#include "active_effects.h"
#include "low_pass.h"

namespace dn {

/// State, with the Earth at its position.
struct Place {
  Place(const TruthTrajectory& truth, double t_s) : state(truth.State(t_s, &earth)) {}

  NormalEarth earth;
  TruthState state;
};

/// Samples the motion as a perfect inertial sensor does. Samples are means over the intervals or
/// values at their ends, after a filter if the scenario has one. The filter's delay is compensated.
class SensorSampling {
 public:
  /// The arguments must outlive this object.
  SensorSampling(const ImuScenario& imu, const TruthTrajectory& truth,
                 const ActiveEffects& effects);

  /// Sets rates and forces of the sample that ends at `to`. The intervals must be given in their
  /// order.
  void operator()(const Place& from, const Place& to, ImuSample* sample);

 private:
  /// Rates in rows 0..2, forces in rows 3..5.
  using Vector = LowPass::Vector;

  Vector Measured(const TruthState& state) const;
  Vector MeanBetween(const Place& from, const Place& to) const;
  Vector Filtered(const Place& from, const Place& to);
  /// Returns the next value of the filter's output, whose input is `delay_s_` later than `t_s`.
  Vector NextFiltered(const Place& from, const Place& to, double t_s);

  const ImuScenario& imu_;
  const TruthTrajectory& truth_;
  const ActiveEffects& effects_;
  int parts_;  // of an interval
  double delay_s_ = 0.0;
  std::optional<LowPass> filter_;
  Vector last_filtered_ = Vector::Zero();
};

}  // namespace dn
