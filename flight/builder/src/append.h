#pragma once

#include <dn/network.h>

#include <vector>

namespace dn::builder_internal {

/// Appends `more` to a list of blocks.
inline void Append(const std::vector<BlockId>& more, std::vector<BlockId>* blocks) {
  blocks->insert(blocks->end(), more.begin(), more.end());
}

}  // namespace dn::builder_internal
