#pragma once

#include <dn/calibration/adjust.h>
#include <dn/navigation/directed_filter.h>

#include <optional>
#include <vector>

namespace dn::internal {

/// The filter that starts at an end of the adjusted trajectory with an open mind about it, and uses
/// what the adjustment has used of GNSS, with its calibration. The adjustment must outlive it.
class OpenFilter {
 public:
  explicit OpenFilter(const Adjustment& adjustment);
  OpenFilter(const OpenFilter&) = delete;
  OpenFilter& operator=(const OpenFilter&) = delete;

  DirectedRun Run(FilterDirection direction) const;

  const Flight& flight() const { return at_epochs_ ? *at_epochs_ : network_.flight(); }
  /// Of the states: those of the GNSS epochs, and what stands between them.
  const std::vector<double>& times() const { return times_; }

 private:
  FilterState StartAt(double t_s) const;

  const FlightNetwork& network_;
  FilterOptions options_;
  std::optional<Flight> at_epochs_;
  std::vector<double> times_;
};

/// Standard deviations that the filter starts with, roll, pitch, heading.
Eigen::Vector3d OpenAttitudeSigma();

}  // namespace dn::internal
