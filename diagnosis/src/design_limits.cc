#include "design_limits.h"

#include <dn/builder/build.h>
#include <dn/diagnosis/limits.h>
#include <dn/interrupted.h>
#include <dn/solvers/marginals.h>

#include <utility>

#include "decision.h"
#include "detection_limits.h"
#include "lap_times.h"
#include "screen.h"
#include "unavailable.h"

namespace dn {
namespace diagnosis_internal {
namespace {

constexpr PlannedRates kRates{.imu_hz = 100.0, .gnss_hz = 1.0};

const Trajectory& FindPoses(const Flight& flight) {
  if (flight.trajectory) return *flight.trajectory;
  return flight.initial_guess ? *flight.initial_guess : *flight.reference;
}

}  // namespace

bool HasPoses(const Flight& flight) {
  return flight.trajectory || flight.initial_guess || flight.reference;
}

Screen ScreenDesign(const Flight& flight, const GapOptions& options, long* rows) {
  Flight plan = flight;
  const NetworkDesign design{FindPoses(flight).ToMapPoses(flight.frame)};
  PlanMeasurements(design, kRates, &plan);
  const FlightNetwork network = Build(plan, design);
  const Marginals marginals(network.net(), {.threads = options.threads});
  if (rows != nullptr) *rows = marginals.linearized().rows();
  return Screen(network, marginals, MakeLibraryOptions(options));
}

GapResult DiagnoseDesignLimits(const Flight& flight, const GapOptions& options) {
  GapDiagnosis diagnosis;
  diagnosis.flight = flight.config.name;
  LapTimes watch(&diagnosis.timings_s);
  const Screen screen = ScreenDesign(flight, options, &diagnosis.validity.observations);
  diagnosis.could_still_hide = ComputeDetectionLimits(screen, kDesignThresholdNats, options.seed);
  watch.Lap("limits");
  return WithLimits(flight, std::move(diagnosis));
}

}  // namespace diagnosis_internal

std::vector<DetectionLimit> DesignDetectionLimits(const Solution& solution,
                                                  const GapOptions& options) {
  options.Validate();
  const auto poll = [&] {
    if (options.interrupted && options.interrupted()) throw Interrupted();
  };
  poll();
  const diagnosis_internal::Screen screen(solution.network(), solution.marginals(),
                                          diagnosis_internal::MakeLibraryOptions(options));
  poll();
  return diagnosis_internal::ComputeDetectionLimits(
      screen, diagnosis_internal::kDesignThresholdNats, options.seed);
}

}  // namespace dn
