#pragma once

#include <dn/diagnosis/diagnose.h>
#include <dn/diagnosis/solution.h>
#include <dn/files/flight.h>

#include <memory>
#include <vector>

#include "forward_selection.h"
#include "hypothesis_evidence.h"
#include "screen.h"

namespace dn::diagnosis_internal {

/// A flight adjusted with some effects in the estimator.
struct NetworkFit : ExtendedFit {
  std::unique_ptr<Flight> flight;  ///< with the adapted configuration
  std::unique_ptr<Solution> solution;
  std::unique_ptr<Screen> screen;
  double raw_only_nats = 0.0;  ///< VarianceScreen::raw_only_nats
  long gnss_left_out = 0;      ///< isolated epochs rejected as outliers

  bool with_boresight() const;
};

/// Adjusts a flight with effects in the estimator, and screens the effects that it lacks.
class NetworkFitter {
 public:
  /// Both arguments must outlive the object.
  NetworkFitter(const Flight& flight, const GapOptions& options);

  /// Adjusts the flight with the chosen effects in the model and screens all others. Fixed effects
  /// take their estimates from this adjustment. Throws as Adjust.
  NetworkFit Fit(const std::vector<HypothesisEvidence>& chosen) const;

  /// Evaluates the processes that may win with the process among the unknowns, and sorts by
  /// evidence again.
  void EvaluateProcesses(NetworkFit* fit) const;

 private:
  Adjustment AdjustWith(const Flight& flight, long* gnss_left_out) const;
  void AddBoresights(NetworkFit* fit) const;
  void AddOutliers(NetworkFit* fit) const;

  const Flight& flight_;
  const GapOptions& options_;
  double node_rate_hz_;
};

}  // namespace dn::diagnosis_internal
