#pragma once

#include <dn/adjustment/finding.h>

#include <vector>

namespace dn::diagnosis_internal {

/// Sorts findings for readers who see the first ones only. Contradicting findings stay before the
/// others. Among each, the first finding of every cause comes before second ones; causes that make
/// many other tests fail (wrong axes, then the GNSS clock) come first, the others keep their order.
void SortByCause(std::vector<Finding>* findings);

}  // namespace dn::diagnosis_internal
