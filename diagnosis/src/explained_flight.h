#pragma once

#include <dn/diagnosis/diagnose.h>
#include <dn/diagnosis/solution.h>
#include <dn/files/flight.h>

#include <memory>
#include <string>
#include <vector>

#include "locations.h"
#include "screen.h"
#include "twins.h"
#include "variances.h"

namespace dn::internal {

/// A flight adjusted with some effects in the estimator (the extended model), and the screen of all
/// other effects.
struct ExtendedFit {
  std::vector<GapCause> causes;
  std::unique_ptr<Flight> flight;  ///< with the adapted configuration
  std::unique_ptr<Solution> solution;
  std::unique_ptr<Screen> screen;
  std::vector<ScreenedEffect> effects;  ///< effects that are not in the model, most probable first
  double coloured_imu_nats = 0.0;  ///< evidence of inertial noise that is not white or not steady
  long gnss_left_out = 0;          ///< isolated epochs rejected as outliers
};

/// Adjusts a flight with an extended model, and screens the effects that the model lacks.
class ExtendedModelFitter {
 public:
  /// Both arguments must outlive the object.
  ExtendedModelFitter(const Flight& flight, const GapOptions& options);

  bool with_pairs() const { return with_pairs_; }
  const GapOptions& options() const { return options_; }

  /// Adjusts the flight with the given causes in the model and screens all other effects. Throws as
  /// Adjust.
  ExtendedFit Explain(const std::vector<GapCause>& causes) const;

  /// Evaluates the processes that may win with the process among the unknowns, and sorts by
  /// evidence again.
  void EvaluateProcesses(ExtendedFit* explained) const;

  /// Makes `twins` linear replicates and compares the flight with them. Fills `appearance`, `all`
  /// and `statistics`.
  ReplicateTest Test(const ExtendedFit& explained, int twins, ResidualSummary* appearance,
                     ReplicateSet* all, std::vector<LocationStatistic>* statistics) const;

 private:
  Adjustment AdjustWith(const Flight& flight, long* gnss_left_out) const;
  void AddOutliers(ExtendedFit* explained) const;

  const Flight& flight_;
  const GapOptions& options_;
  bool with_pairs_;
};

}  // namespace dn::internal
