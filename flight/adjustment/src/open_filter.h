#pragma once

#include <dn/adjustment/adjust.h>
#include <dn/navigation/directed_filter.h>

#include <optional>
#include <vector>

namespace dn::adjustment_internal {

/// A filter that starts at either end of the adjusted trajectory with a diffuse prior. It uses the
/// calibration of the adjustment and the GNSS data that the adjustment has kept. The adjustment
/// must outlive it.
class DiffusePriorFilter {
 public:
  explicit DiffusePriorFilter(const Adjustment& adjustment);
  DiffusePriorFilter(const DiffusePriorFilter&) = delete;
  DiffusePriorFilter& operator=(const DiffusePriorFilter&) = delete;

  DirectedRun Run(FilterDirection direction) const;

  const Flight& flight() const { return at_epochs_ ? *at_epochs_ : network_.flight(); }
  /// Returns the times of the states: those of the GNSS epochs, and filter epochs between them.
  const std::vector<double>& times() const { return times_; }

 private:
  FilterState StartAt(double t_s) const;

  const FlightNetwork& network_;
  FilterOptions options_;
  std::optional<Flight> at_epochs_;
  std::vector<double> times_;
};

/// Returns the initial standard deviations of roll, pitch and heading, rad.
Eigen::Vector3d DiffuseAttitudeSigma();

}  // namespace dn::adjustment_internal
