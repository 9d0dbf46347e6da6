#pragma once

#include <dn/matching/match_source.h>
#include <dn/parallel.h>

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace dn::matching_internal {

/// Computes the positions of points of a strip with the present alignment. x: like RawPoints::x, in
/// float or double.
template <class Scalar>
void PlacePoints(const MatchSource& source, std::size_t strip, const std::vector<double>& t_s,
                 const std::vector<Eigen::Matrix<Scalar, 3, 1>>& x, int threads,
                 std::vector<Eigen::Vector3d>* p_m) {
  constexpr std::size_t kPointsPerTask = 4096;
  p_m->resize(t_s.size());
  ParallelForChunks(t_s.size(), kPointsPerTask, threads,
                    [&](std::size_t, std::size_t first, std::size_t past) {
                      for (std::size_t i = first; i < past; ++i) {
                        (*p_m)[i] = source.Position(strip, t_s[i], x[i].template cast<double>());
                      }
                    });
}

}  // namespace dn::matching_internal
