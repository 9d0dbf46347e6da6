#include "block_pattern.h"

#include <algorithm>
#include <cstdint>

namespace dn {
namespace {

/// Pairs (column, row) of blocks with row >= column, packed into one number each.
class BlockPairs {
 public:
  /// All pairs of the blocks of one factor, by their positions.
  void Add(const int* position, int num_blocks) {
    for (int a = 0; a < num_blocks; ++a) {
      for (int b = 0; b < num_blocks; ++b) {
        if (position[a] < position[b]) continue;
        pairs_.push_back(static_cast<std::uint64_t>(position[b]) << 32 |
                         static_cast<std::uint64_t>(position[a]));
      }
    }
  }

  SymmetricCsc Pattern(int num_blocks) {
    std::sort(pairs_.begin(), pairs_.end());
    pairs_.erase(std::unique(pairs_.begin(), pairs_.end()), pairs_.end());
    SymmetricCsc pattern;
    pattern.n = num_blocks;
    pattern.column_start.assign(AsSize(num_blocks) + 1, 0);
    pattern.row.reserve(pairs_.size());
    for (const std::uint64_t pair : pairs_) {
      ++pattern.column_start[(pair >> 32) + 1];
      pattern.row.push_back(static_cast<int>(pair & 0xffffffffU));
    }
    for (std::size_t c = 1; c < pattern.column_start.size(); ++c) {
      pattern.column_start[c] += pattern.column_start[c - 1];
    }
    return pattern;
  }

 private:
  std::vector<std::uint64_t> pairs_;
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
      const int position = layout.position_of[AsSize(b)];
      if (position >= 0) positions.push_back(position);
    }
    pairs.Add(positions.data(), static_cast<int>(positions.size()));
  }
  return pairs.Pattern(layout.num_blocks());
}

}  // namespace dn
