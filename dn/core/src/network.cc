#include <dn/manifold_check.h>
#include <dn/names.h>
#include <dn/network.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <exception>
#include <new>
#include <utility>

namespace dn {
namespace {

/// Returns the given value projected onto the manifold of the block.
Eigen::VectorXd OnManifold(const BlockRecord& record, const double* value) {
  const Eigen::Map<const Eigen::VectorXd> given(value, record.kind.stored_size);
  if (record.kind.parametrisation == Parametrisation::kVector) return given;
  if (record.kind.parametrisation != Parametrisation::kManifold) {
    const double norm = given.norm();
    if (!(norm > 1e-9))
      throw InvalidInput("network: quaternion of block '" + record.name + "' has zero norm");
    return given * (1.0 / norm);
  }
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(record.kind.tangent_size);
  Eigen::VectorXd x(record.kind.stored_size);
  Plus(record.kind, value, zero.data(), x.data());
  if (!x.allFinite() || !TangentLift(record.kind, x.data()).allFinite()) {
    throw InvalidInput("network: value of block '" + record.name +
                       "' is not on its manifold: Plus does not move it in every direction");
  }
  return x;
}

bool HasValidSizes(const BlockKind& kind) {
  switch (kind.parametrisation) {
    case Parametrisation::kVector:
      return kind.stored_size > 0 && kind.tangent_size == kind.stored_size;
    case Parametrisation::kRotationRight:
    case Parametrisation::kRotationLeft:
      return kind.stored_size == 4 && kind.tangent_size == 3;
    case Parametrisation::kManifold:
      break;
  }
  return kind.manifold != nullptr && kind.stored_size > 0 && kind.tangent_size > 0;
}

NetworkId NextNetworkId() {
  static std::atomic<NetworkId> last = 0;
  return ++last;
}

std::unique_ptr<BlockRecord> CopyRecord(const BlockRecord& record) {
  const int size = record.kind.stored_size;
  auto copy = std::make_unique<BlockRecord>(BlockRecord{record.name, record.kind, StoredValue(size),
                                                        record.held, record.label, record.network,
                                                        record.owner});
  std::copy_n(record.value.get(), size, copy->value.get());
  return copy;
}

}  // namespace

Network::Network(Network&& other) noexcept
    : id_(std::exchange(other.id_, 0)),
      blocks_(std::move(other.blocks_)),
      factors_(std::move(other.factors_)),
      by_name_(std::move(other.by_name_)),
      groups_(std::move(other.groups_)),
      checked_(std::move(other.checked_)) {
  other.Clear();
}

Network& Network::operator=(Network&& other) noexcept {
  if (this == &other) return *this;
  id_ = std::exchange(other.id_, 0);
  blocks_ = std::move(other.blocks_);
  factors_ = std::move(other.factors_);
  by_name_ = std::move(other.by_name_);
  groups_ = std::move(other.groups_);
  checked_ = std::move(other.checked_);
  other.Clear();
  return *this;
}

Network::Network(const Network& other)
    : factors_(other.factors_),
      by_name_(other.by_name_),
      groups_(other.groups_),
      checked_(other.checked_) {
  blocks_.reserve(other.blocks_.size());
  for (const auto& block : other.blocks_) blocks_.push_back(CopyRecord(*block));
}

void Network::Clear() noexcept {
  blocks_.clear();
  factors_.clear();
  by_name_.clear();
  groups_.clear();
}

Network& Network::operator=(const Network& other) {
  if (this != &other) *this = Network(other);
  return *this;
}

Block<Rotation> Network::AddRotation(const std::string& name, const Eigen::Quaterniond& q) {
  return Handle<Rotation>(AddStored(name, Rotation::kKind, q.coeffs().data()));
}

Block<LeftRotation> Network::AddLeftRotation(const std::string& name, const Eigen::Quaterniond& q) {
  return Handle<LeftRotation>(AddStored(name, LeftRotation::kKind, q.coeffs().data()));
}

BlockId Network::AddStored(const std::string& name, const BlockKind& kind, const double* value,
                           std::shared_ptr<const void> owner) {
  const BlockId id = num_blocks();
  if (by_name_.contains(name)) throw InvalidInput("network: block name '" + name + "' is taken");
  if (id_ == 0) id_ = NextNetworkId();
  blocks_.push_back(std::make_unique<BlockRecord>(
      BlockRecord{name, kind, StoredValue(kind.stored_size), false, {}, id_, std::move(owner)}));
  try {
    SetRaw(id, value);
    CheckNewKind(*blocks_.back());
  } catch (...) {
    blocks_.pop_back();
    throw;
  }
  by_name_.emplace(name, id);
  return id;
}

void Network::CheckNewKind(const BlockRecord& record) {
  if (record.kind.parametrisation != Parametrisation::kManifold) return;
  if (std::find(checked_.begin(), checked_.end(), record.kind.manifold) != checked_.end()) return;
  CheckManifold(record.kind, record.value.get(), record.name);
  checked_.push_back(record.kind.manifold);
}

void Network::SetRaw(BlockId id, const double* value) {
  BlockRecord& record = block_present(id);
  const Eigen::Map<const Eigen::VectorXd> given(value, record.kind.stored_size);
  if (!given.allFinite())
    throw InvalidInput("network: value of block '" + record.name + "' is not finite");
  std::copy_n(OnManifold(record, value).data(), record.kind.stored_size, record.value.get());
}

Eigen::VectorXd Network::Value(BlockId id) const {
  const BlockRecord& record = block(id);
  return Eigen::Map<const Eigen::VectorXd>(record.value.get(), record.kind.stored_size);
}

void Network::SetValue(BlockId id, const Eigen::VectorXd& value) {
  const BlockRecord& record = block_present(id);
  if (value.size() != record.kind.stored_size) {
    throw InvalidInput("network: " + std::to_string(value.size()) + " numbers for block '" +
                       record.name + "', which has " + std::to_string(record.kind.stored_size));
  }
  SetRaw(id, value.data());
}

BlockId Network::AddBlock(const std::string& name, const BlockKind& kind,
                          const Eigen::VectorXd& value, std::shared_ptr<const void> owner) {
  if (!HasValidSizes(kind) || value.size() != kind.stored_size) {
    throw InvalidInput("network: the kind of block '" + name + "' has " +
                       std::to_string(kind.stored_size) + " stored numbers and " +
                       std::to_string(kind.tangent_size) +
                       " tangent coordinates, which do not fit its parametrisation or the " +
                       std::to_string(value.size()) + " numbers of the value");
  }
  return AddStored(name, kind, value.data(), std::move(owner));
}

void Network::RemoveBlocks(const std::vector<BlockId>& ids) {
  std::vector<bool> removed(blocks_.size(), false);
  for (const BlockId id : ids) {
    block_present(id);
    removed[static_cast<std::size_t>(id)] = true;
  }
  for (FactorId f = 0; f < num_factors(); ++f) {
    const std::vector<BlockId>& blocks = factor(f).blocks;
    if (std::any_of(blocks.begin(), blocks.end(),
                    [&](BlockId b) { return removed[static_cast<std::size_t>(b)]; })) {
      RemoveFactor(f);
    }
  }
  for (const BlockId id : ids) {
    by_name_.erase(block(id).name);
    block(id) = BlockRecord();
    block(id).held = true;
  }
}

FactorId Network::AddFactor(std::shared_ptr<const FactorBase> factor,
                            const std::vector<BlockId>& blocks) {
  if (factor == nullptr || factor->residual_size() < 1 || factor->block_kinds().empty()) {
    throw InvalidInput("network: a factor needs at least one residual and one block");
  }
  const std::vector<BlockKind>& kinds = factor->block_kinds();
  if (kinds.size() != blocks.size()) {
    throw InvalidInput("network: factor takes " + std::to_string(kinds.size()) + " blocks, " +
                       std::to_string(blocks.size()) + " given");
  }
  for (std::size_t i = 0; i < kinds.size(); ++i) {
    block_present(blocks[i]);
    if (!(block(blocks[i]).kind == kinds[i])) {
      throw InvalidInput("network: block '" + block(blocks[i]).name +
                         "' is of the wrong kind for argument " + std::to_string(i) +
                         " of the factor");
    }
    if (std::find(blocks.begin(), blocks.begin() + static_cast<std::ptrdiff_t>(i), blocks[i]) !=
        blocks.begin() + static_cast<std::ptrdiff_t>(i)) {
      throw InvalidInput("network: block '" + block(blocks[i]).name +
                         "' is given twice to one factor");
    }
  }
  const FactorId id = num_factors();
  if (groups_.empty()) groups_.emplace_back();  // this network was moved from
  factors_.push_back({});
  factors_.back().factor = std::move(factor);
  factors_.back().blocks = blocks;
  return id;
}

void Network::ReplaceFactor(FactorId id, std::shared_ptr<const FactorBase> factor) {
  FactorRecord& record = factor_mutable(id);
  if (factor == nullptr || factor->residual_size() != record.factor->residual_size() ||
      factor->block_kinds() != record.factor->block_kinds()) {
    throw InvalidInput("network: the replacement of factor " + std::to_string(id) +
                       " has different block kinds or a different residual size");
  }
  record.factor = std::move(factor);
}

void Network::RemoveFactor(FactorId id) {
  FactorRecord& record = factor_mutable(id);
  record.factor.reset();
  record.blocks.clear();
  record.active = false;
}

void Network::Tag(FactorId id, const FactorGroup& group, double t_s) {
  FactorRecord& record = factor_mutable(id);
  const auto residuals = static_cast<std::size_t>(record.factor->residual_size());
  if (!group.rows.empty() && group.rows.size() != residuals) {
    throw InvalidInput("network: group '" + group.name + "' names " +
                       std::to_string(group.rows.size()) + " residuals, factor " +
                       std::to_string(id) + " has " + std::to_string(residuals));
  }
  auto it = std::find(groups_.begin(), groups_.end(), group);
  if (it == groups_.end()) it = groups_.insert(groups_.end(), group);
  record.group = static_cast<int>(it - groups_.begin());
  record.t_s = t_s;
}

void Network::SetLoss(FactorId id, Loss loss) {
  if (loss.type == Loss::Type::kFunction && (loss.function == nullptr || !*loss.function)) {
    throw InvalidInput("network: a robust loss of one's own needs its function");
  }
  if (loss.type != Loss::Type::kNone && !(loss.width > 0.0 && std::isfinite(loss.width))) {
    throw InvalidInput("network: the width of a robust loss is " + std::to_string(loss.width) +
                       ", must be positive and finite");
  }
  factor_mutable(id).loss = loss;
}

void Network::SetLabel(BlockId id, BlockLabel label) {
  BlockRecord& record = block_present(id);
  const auto tangent_size = static_cast<std::size_t>(record.kind.tangent_size);
  if (!label.components.empty() && label.components.size() != tangent_size) {
    throw InvalidInput("network: the label of block '" + record.name + "' names " +
                       std::to_string(label.components.size()) + " components, the block has " +
                       std::to_string(tangent_size));
  }
  record.label = std::move(label);
}

void CheckHandle(const std::string& name, const BlockKind& kind, NetworkId network,
                 const BlockKind& expected_kind, NetworkId expected_network) {
  if (kind.stored_size == 0) throw InvalidInput("network: the block of this handle was removed");
  if (expected_network != 0 && expected_network != network) {
    throw InvalidInput("network: the handle of a block of another network is used for block '" +
                       name + "' of this network; find the block by its name");
  }
  if (!(kind == expected_kind)) {
    throw InvalidInput(
        "network: block '" + name +
        "' has a different kind than the handle; does the handle belong to another network?");
  }
}

BlockId Network::Find(const std::string& name) const {
  if (const auto it = by_name_.find(name); it != by_name_.end()) return it->second;
  std::vector<std::string> names;
  for (const auto& record : blocks_) names.push_back(record->name);
  throw InvalidInput("network: there is no block '" + name + "'; the nearest name is '" +
                     NearestName(name, names) + "'");
}

const BlockRecord& Network::block(BlockId id) const {
  if (id < 0 || id >= num_blocks())
    throw InvalidInput("network: no block with id " + std::to_string(id));
  return *blocks_[static_cast<std::size_t>(id)];
}

BlockRecord& Network::block(BlockId id) {
  return const_cast<BlockRecord&>(static_cast<const Network*>(this)->block(id));
}

BlockRecord& Network::block_present(BlockId id) {
  BlockRecord& record = block(id);
  if (record.removed()) {
    throw InvalidInput("network: block " + std::to_string(id) + " was removed");
  }
  return record;
}

const FactorRecord& Network::factor(FactorId id) const {
  if (id < 0 || id >= num_factors())
    throw InvalidInput("network: no factor with id " + std::to_string(id));
  return factors_[static_cast<std::size_t>(id)];
}

const FactorRecord& Network::factor_present(FactorId id) const {
  const FactorRecord& record = factor(id);
  if (record.factor == nullptr) {
    throw InvalidInput("network: factor " + std::to_string(id) + " was removed");
  }
  return record;
}

FactorRecord& Network::factor_mutable(FactorId id) {
  return const_cast<FactorRecord&>(factor_present(id));
}

int Network::num_free_parameters() const {
  int n = 0;
  for (const auto& record : blocks_) n += record->held ? 0 : record->kind.tangent_size;
  return n;
}

std::string Network::DescribeFactor(FactorId id) const {
  const FactorRecord& record = factor(id);
  std::string details = group(id).name;
  if (std::isfinite(record.t_s)) {
    char time[48];
    std::snprintf(time, sizeof(time), "%s%.3f s", details.empty() ? "" : ", ", record.t_s);
    details += time;
  }
  std::string text = "factor ";
  text += std::to_string(id);
  if (!details.empty()) text.append(" (").append(details).append(")");
  text += record.factor == nullptr ? ", removed" : " on";
  for (const BlockId b : record.blocks) text.append(" '").append(block(b).name).append("'");
  return text;
}

void Network::NameException(FactorId id) const {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    std::throw_with_nested(InvalidInput(DescribeFactor(id) + " throws: " + error.what()));
  } catch (...) {
    std::throw_with_nested(InvalidInput(DescribeFactor(id) + " throws an unknown exception"));
  }
}

bool Network::EvaluateFactor(FactorId id, Eigen::VectorXd* r,
                             std::vector<Eigen::MatrixXd>* J) const {
  const FactorRecord& record = factor_present(id);
  std::vector<const double*> x;
  for (const BlockId b : record.blocks) x.push_back(block(b).value.get());
  try {
    return EvaluateInTangent(*record.factor, x, r, J);
  } catch (...) {
    NameException(id);
  }
}

bool Network::EvaluateStored(FactorId id, double const* const* x, double* r, double** J) const {
  const FactorBase& factor = *factor_present(id).factor;
  try {
    return dn::EvaluateStored(factor, x, r, J);
  } catch (...) {
    NameException(id);
  }
}

}  // namespace dn
