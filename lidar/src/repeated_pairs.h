#pragma once

#include <dn/lidar/pairs.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace dn::lidar_internal {

/// Epochs and vectors of a pair, ordered so that the smaller end is first.
using PairKey = std::array<double, 8>;

inline PairKey MakeKey(const LidarPair& pair) {
  const PairKey key{pair.t_i_s, pair.u_i_s.x(), pair.u_i_s.y(), pair.u_i_s.z(),
                    pair.t_j_s, pair.u_j_s.x(), pair.u_j_s.y(), pair.u_j_s.z()};
  PairKey swapped = key;
  std::rotate(swapped.begin(), swapped.begin() + 4, swapped.end());
  return std::min(key, swapped);
}

/// Keeps the first of several equal pairs, where i and j may be exchanged; returns the number of
/// dropped pairs. `ends` returns the LidarPair of an element.
template <class Pair, class Ends>
long DropRepeats(std::vector<Pair>& pairs, const Ends& ends) {
  std::vector<std::pair<PairKey, std::size_t>> order;
  order.reserve(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) order.emplace_back(MakeKey(ends(pairs[i])), i);
  std::sort(order.begin(), order.end());
  std::vector<bool> repeated(pairs.size(), false);
  for (std::size_t i = 1; i < order.size(); ++i) {
    repeated[order[i].second] = order[i].first == order[i - 1].first;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (!repeated[i]) pairs[kept++] = pairs[i];
  }
  const auto dropped = static_cast<long>(pairs.size() - kept);
  pairs.resize(kept);
  return dropped;
}

}  // namespace dn::lidar_internal
