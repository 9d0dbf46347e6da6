#pragma once

#include <dn/navigation/forward_filter.h>

#include <vector>

namespace dn {

enum class FilterDirection { kForward, kReverse };

/// A run with how well each state knows its heading.
struct DirectedRun : FilterRun {
  std::vector<double> sigma_heading_rad;  ///< per state, of its attitude about the vertical
};

/// RunForwardFilter, or the same filter from the end of the flight to its begin: the edges solved
/// for their earlier pose, the processes stepped back. A Gauss-Markov process looks alike in both
/// directions; the variance of a random walk in the start of a reverse run must be that of its value
/// at the end.
///
/// times: rising, for either direction. A reverse run leaves out those after start.pose.t_s, and has
/// its states in the order of falling time; options.t_end_s has no meaning for it.
DirectedRun RunFilter(const Flight& flight, const std::vector<double>& times,
                      const FilterState& start, FilterDirection direction,
                      const FilterOptions& options = {});

}  // namespace dn
