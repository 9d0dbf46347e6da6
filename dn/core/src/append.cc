#include <dn/network.h>

#include <algorithm>

namespace dn {
namespace {

template <class Id>
Id AppendedId(const std::vector<Id>& ids, Id other, const char* what) {
  if (other < 0 || other >= static_cast<Id>(ids.size()) ||
      ids[static_cast<std::size_t>(other)] < 0) {
    throw InvalidInput(std::string("network: the appended network has no ") + what + " with id " +
                       std::to_string(other));
  }
  return ids[static_cast<std::size_t>(other)];
}

bool Contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

BlockId Network::Appended::Id(BlockId other) const { return AppendedId(blocks_, other, "block"); }

FactorId Network::Appended::Factor(FactorId other) const {
  return AppendedId(factors_, other, "factor");
}

NetworkId Network::Appended::CheckedNetwork(BlockId other, NetworkId network) const {
  const auto [there, here] = networks_[static_cast<std::size_t>(other)];
  if (network != 0 && network != there) {
    throw InvalidInput("network: the handle of block " + std::to_string(other) +
                       " does not belong to the appended network");
  }
  return here;
}

std::vector<BlockId> Network::FindShared(const Network& other, const std::string& prefix,
                                         const std::vector<std::string>& shared) const {
  for (const std::string& name : shared) other.Find(name);
  std::vector<BlockId> ids(other.blocks_.size(), -1);
  for (std::size_t b = 0; b < ids.size(); ++b) {
    const BlockRecord& record = *other.blocks_[b];
    if (record.removed()) continue;
    const bool is_shared = Contains(shared, record.name);
    const auto here = by_name_.find(is_shared ? record.name : prefix + record.name);
    if (here == by_name_.end()) continue;
    if (!is_shared) {
      throw InvalidInput("network: block name '" + here->first +
                         "' of the appended network is taken; give another prefix, or name '" +
                         record.name + "' as shared");
    }
    if (!(block(here->second).kind == record.kind)) {
      throw InvalidInput("network: the shared block '" + record.name +
                         "' of the appended network has a different kind");
    }
    ids[b] = here->second;
  }
  return ids;
}

Network::Appended Network::Append(const Network& other, const std::string& prefix,
                                  const std::vector<std::string>& shared) {
  if (this == &other) return Append(Network(other), prefix, shared);
  Appended appended;
  appended.blocks_ = FindShared(other, prefix, shared);
  for (std::size_t b = 0; b < other.blocks_.size(); ++b) {
    const BlockRecord& there = *other.blocks_[b];
    if (!there.removed() && appended.blocks_[b] < 0) {
      const std::string name = Contains(shared, there.name) ? there.name : prefix + there.name;
      appended.blocks_[b] = AddStored(name, there.kind, there.value.get(), there.owner);
      block(appended.blocks_[b]).held = there.held;
      block(appended.blocks_[b]).label = there.label;
    }
    const NetworkId here = there.removed() ? 0 : block(appended.blocks_[b]).network;
    appended.networks_.emplace_back(there.network, here);
  }
  for (const FactorRecord& record : other.factors_) {
    appended.factors_.push_back(-1);
    if (record.factor == nullptr) continue;
    std::vector<BlockId> blocks;
    for (const BlockId b : record.blocks) blocks.push_back(appended.Id(b));
    const FactorId id = AddFactor(record.factor, blocks);
    appended.factors_.back() = id;
    Tag(id, other.groups_[static_cast<std::size_t>(record.group)], record.t_s);
    SetLoss(id, record.loss);
    SetActive(id, record.active);
  }
  return appended;
}

}  // namespace dn
