#include <dn/error.h>
#include <dn/linear_prior.h>
#include <dn/names.h>
#include <dn/network_state.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <memory>
#include <utility>

namespace dn {
namespace {

void ExpectKind(const NetworkState::Block& block, const BlockKind& kind) {
  if (block.parametrisation == kind.parametrisation && block.value.size() == kind.stored_size) {
    return;
  }
  throw InvalidInput("network state: block '" + block.name + "' has another kind in the network");
}

std::shared_ptr<const LinearPrior> MakePrior(const NetworkState::Prior& prior,
                                             const Network& network) {
  std::vector<BlockKind> kinds;
  for (const std::string& name : prior.blocks) {
    kinds.push_back(network.block(network.Find(name)).kind);
  }
  return std::make_shared<const LinearPrior>(std::move(kinds), prior.center, prior.R, prior.d,
                                             prior.nonlinearity);
}

FactorId AddToNetwork(std::shared_ptr<const LinearPrior> prior,
                      const std::vector<std::string>& names, const std::string& group,
                      Network* network) {
  std::vector<BlockId> blocks;
  for (const std::string& name : names) blocks.push_back(network->Find(name));
  const FactorId id = network->AddFactor(std::move(prior), blocks);
  network->Tag(id, FactorGroup{group, {}, "", FactorGroup::Kind::kPrior},
               std::numeric_limits<double>::quiet_NaN());
  return id;
}

}  // namespace

const NetworkState::Block& NetworkState::Find(const std::string& name) const {
  std::vector<std::string> names;
  for (const Block& block : blocks) {
    if (block.name == name) return block;
    names.push_back(block.name);
  }
  throw InvalidInput("network state: there is no block '" + name + "'; the nearest name is '" +
                     NearestName(name, names) + "'");
}

NetworkState GetState(const Network& network) {
  NetworkState state;
  for (BlockId b = 0; b < network.num_blocks(); ++b) {
    const BlockRecord& record = network.block(b);
    if (record.removed()) continue;
    state.blocks.push_back({record.name, record.kind.parametrisation, network.Value(b), {}});
  }
  for (FactorId id = 0; id < network.num_factors(); ++id) {
    const FactorRecord& record = network.factor(id);
    const auto* prior = dynamic_cast<const LinearPrior*>(record.factor.get());
    if (!record.active || prior == nullptr) continue;
    NetworkState::Prior stored{network.group(id).name, {},
                               prior->center(),        prior->sqrt_information(),
                               prior->offset(),        prior->nonlinearity()};
    for (const BlockId b : record.blocks) stored.blocks.push_back(network.block(b).name);
    state.priors.push_back(std::move(stored));
  }
  return state;
}

void SetState(const NetworkState& state, Network* network) {
  for (const NetworkState::Block& block : state.blocks) {
    ExpectKind(block, network->block(network->Find(block.name)).kind);
  }
  std::vector<std::shared_ptr<const LinearPrior>> priors;
  for (const NetworkState::Prior& prior : state.priors) {
    priors.push_back(MakePrior(prior, *network));
  }
  for (const NetworkState::Block& block : state.blocks) {
    network->SetValue(network->Find(block.name), block.value);
  }
  for (std::size_t k = 0; k < priors.size(); ++k) {
    AddToNetwork(priors[k], state.priors[k].blocks, state.priors[k].group, network);
  }
}

FactorId AddPrior(const NetworkState::Block& block, Network* network) {
  const BlockKind& kind = network->block(network->Find(block.name)).kind;
  ExpectKind(block, kind);
  const Eigen::Index n = kind.tangent_size;
  const Eigen::MatrixXd& C = block.covariance;
  const Eigen::LLT<Eigen::MatrixXd> llt(C);
  if (C.rows() != n || C.cols() != n || !C.allFinite() || llt.info() != Eigen::Success) {
    throw InvalidInput("network state: the covariance of block '" + block.name +
                       "' is missing or not positive definite");
  }
  const Eigen::MatrixXd R = llt.matrixL().solve(Eigen::MatrixXd::Identity(n, n));
  auto prior = std::make_shared<const LinearPrior>(std::vector<BlockKind>{kind}, block.value, R,
                                                   Eigen::VectorXd::Zero(n));
  return AddToNetwork(std::move(prior), {block.name}, "prior", network);
}

}  // namespace dn
