#pragma once

#include <dn/navigation/forward_filter.h>

#include <vector>

namespace dn {

enum class FilterDirection { kForward, kReverse };

/// A filter run with the heading sigma of each state.
struct DirectedRun : FilterRun {
  /// One per state: sigma of the rotation about the vertical.
  std::vector<double> sigma_heading_rad;
};

/// Runs RunForwardFilter, or the same filter from the end of the flight to its start. In reverse,
/// the inertial edges are solved for their earlier pose and the processes are predicted backwards.
/// A Gauss-Markov process has the same statistics in both directions. For a random walk, the
/// variance in the start of a reverse run must be that of its value at the end.
///
/// times: ascending for both directions. A reverse run leaves out the times after start.pose.t_s
/// and returns its states in descending order of time; it ignores options.t_end_s.
DirectedRun RunFilter(const Flight& flight, const std::vector<double>& times,
                      const FilterState& start, FilterDirection direction,
                      const FilterOptions& options = {});

}  // namespace dn
