#include "sparse/block_pattern.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

namespace dn::sparse {
namespace {

/// Pairs (column, row) of blocks with row >= column. A pair appears once per factor that contains
/// it.
class BlockPairs {
 public:
  /// Adds all pairs of the blocks of one factor, given by their positions.
  void Add(const int* position, int num_blocks) {
    for (int a = 0; a < num_blocks; ++a) {
      for (int b = 0; b < num_blocks; ++b) {
        if (position[a] >= position[b]) pairs_.push_back({position[b], position[a]});
      }
    }
  }

  SymmetricCsc Pattern(int num_blocks) const {
    const std::vector<int> start = Starts(num_blocks);
    const std::vector<int> rows = ByColumn(start);
    SymmetricCsc pattern;
    pattern.n = num_blocks;
    pattern.column_start.assign(1, 0);
    std::vector<int> seen_in(AsSize(num_blocks), -1);
    for (int c = 0; c < num_blocks; ++c) {
      for (int k = start[AsSize(c)]; k < start[AsSize(c) + 1]; ++k) {
        const int row = rows[AsSize(k)];
        if (std::exchange(seen_in[AsSize(row)], c) != c) pattern.row.push_back(row);
      }
      std::sort(pattern.row.begin() + pattern.column_start.back(), pattern.row.end());
      pattern.column_start.push_back(static_cast<int>(pattern.row.size()));
    }
    return pattern;
  }

 private:
  struct Pair {
    int column, row;
  };

  std::vector<int> Starts(int num_blocks) const {
    std::vector<int> start(AsSize(num_blocks) + 1, 0);
    for (const Pair& pair : pairs_) ++start[AsSize(pair.column) + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    return start;
  }

  std::vector<int> ByColumn(std::vector<int> next) const {
    std::vector<int> rows(pairs_.size());
    for (const Pair& pair : pairs_) rows[AsSize(next[AsSize(pair.column)]++)] = pair.row;
    return rows;
  }

  std::vector<Pair> pairs_;
};

}  // namespace

SymmetricCsc BlockPattern(const UnknownLayout& layout, const Linearization& linearization) {
  BlockPairs pairs;
  for (const Linearization::Edge& edge : linearization.edges()) {
    pairs.Add(linearization.positions(edge), edge.num_blocks);
  }
  return pairs.Pattern(layout.num_blocks());
}

SymmetricCsc BlockPattern(const UnknownLayout& layout, const Network& network) {
  BlockPairs pairs;
  std::vector<int> positions;
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    const FactorRecord& record = network.factor(id);
    if (!record.active) continue;
    positions.clear();
    for (const BlockId b : record.blocks) {
      const int position = layout.block_position[AsSize(b)];
      if (position >= 0) positions.push_back(position);
    }
    pairs.Add(positions.data(), static_cast<int>(positions.size()));
  }
  return pairs.Pattern(layout.num_blocks());
}

}  // namespace dn::sparse
