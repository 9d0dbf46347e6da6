#pragma once

#include <dn/calibration/solution.h>
#include <dn/flight/flight.h>
#include <dn/gap/diagnose.h>

#include <memory>
#include <string>
#include <vector>

#include "locations.h"
#include "screen.h"
#include "twins.h"
#include "variances.h"

namespace dn::internal {

/// A flight adjusted with some effects in the estimator, and what else its residuals show.
struct ExplainedFlight {
  std::vector<GapCause> causes;
  std::unique_ptr<Flight> flight;  ///< with the adapted configuration
  std::unique_ptr<Solution> solution;
  std::unique_ptr<Screen> screen;
  std::vector<ScreenedEffect> effects;  ///< all that are not in it, the likeliest first
  double coloured_imu_nats = 0.0;       ///< for inertial noise that is not white or not steady
  long gnss_left_out = 0;
};

/// Adjusts and screens.
class Explainer {
 public:
  /// Both must outlive it.
  Explainer(const Flight& flight, const GapOptions& options);

  bool with_pairs() const { return with_pairs_; }
  const GapOptions& options() const { return options_; }

  /// Throws as Adjust.
  ExplainedFlight Explain(const std::vector<GapCause>& causes) const;

  /// The evidence of processes that may win, with the process among the unknowns; sorts anew.
  void JudgeProcesses(ExplainedFlight* explained) const;

  /// Twins of it, and the flight against them.
  TwinTest Test(const ExplainedFlight& explained, int twins, Appearance* appearance, Twins* all,
                std::vector<LocationStatistic>* statistics) const;

 private:
  Adjustment AdjustWith(const Flight& flight, long* gnss_left_out) const;
  void AddOutliers(ExplainedFlight* explained) const;

  const Flight& flight_;
  const GapOptions& options_;
  bool with_pairs_;
};

}  // namespace dn::internal
