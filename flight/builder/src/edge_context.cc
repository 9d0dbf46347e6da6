#include <dn/builder/edge_context.h>

#include <utility>

namespace dn {

FactorId MadeFactors::Add(std::shared_ptr<const FactorBase> factor,
                          const std::vector<BlockId>& blocks, const FactorGroup& group,
                          double t_s) {
  const std::weak_ptr<const FactorBase> made = factor;
  const FactorId id = net_.AddFactor(std::move(factor), blocks);
  net_.Tag(id, group, t_s);
  made_[id] = made;
  return id;
}

}  // namespace dn
