#pragma once

#include <dn/matching/match_source.h>

#include <Eigen/Core>
#include <functional>
#include <vector>

namespace dn::matching_internal {

/// Points of a strip, about one per cell of a horizontal grid, for the coarse levels.
struct StripSample {
  std::vector<double> t_s;
  /// In the form of RawPoints::x; float has a resolution of 0.2 mm at 3 km.
  std::vector<Eigen::Vector3f> x;
  std::vector<Eigen::Vector3d> p_m;  ///< with the present alignment (Place)
  StripCounts counts;
  double point_density_m2 = 0.0;  ///< points per square metre of the ground that the strip covers

  std::size_t size() const { return t_s.size(); }
};

/// Samples a strip: keeps the point nearest to the centre of each cell. The memory grows with the
/// area, not with the number of points. `told` is called with the number of points read, and may
/// throw.
StripSample SampleStrip(const MatchSource& source, std::size_t strip, double cell_m, int threads,
                        const std::function<void(std::uint64_t)>& told);

/// Computes the positions with the present alignment.
void Place(const MatchSource& source, std::size_t strip, int threads, StripSample* sample);

}  // namespace dn::matching_internal
