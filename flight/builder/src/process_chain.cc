#include <dn/builder/node_grid.h>
#include <dn/builder/process_chain.h>
#include <dn/error.h>
#include <dn/factors/bias_process.h>
#include <dn/factors/prior.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace dn {
namespace {

constexpr double kSameTimeS = 1e-6;

double PriorSigma(const BiasProcess& process, const ConstantInterval& first) {
  if (process.type != BiasProcess::Type::kRandomWalk) return process.sigma;
  return process.sigma * std::sqrt(std::max(first.t_mid_s - first.t_begin_s, 1e-3));
}

/// Adds the prior of the first block and the transitions of a first-order process.
void AddFirstOrder(const ProcessChain& chain, const ConstantInterval& first,
                   const ChainNames& names, Network* net) {
  const BiasProcess& process = chain.process;
  const Noise<3> noise = Noise<3>::Sigma(PriorSigma(process, first));
  net->Tag(net->Add(PriorVector<3>(Eigen::Vector3d::Zero(), noise), chain.blocks.front()),
           names.prior, chain.t_mid_s.front());
  for (std::size_t k = 0; k + 1 < chain.blocks.size(); ++k) {
    const double dt_s = chain.t_mid_s[k + 1] - chain.t_mid_s[k];
    const FactorId id =
        process.type == BiasProcess::Type::kGaussMarkov
            ? net->Add(GaussMarkovEdge(process.sigma, process.tau_s, dt_s), chain.blocks[k],
                       chain.blocks[k + 1])
            : net->Add(RandomWalkEdge(process.sigma, dt_s), chain.blocks[k], chain.blocks[k + 1]);
    net->Tag(id, names.group, chain.t_mid_s[k]);
  }
}

/// Gives the factors from `begin` on that have no group those of the chain.
void TagOwnFactors(const ProcessChain& chain, const ChainNames& names, FactorId begin,
                   Network* net) {
  const BlockId front = chain.blocks.front().id;  // the ids of the blocks are consecutive
  const auto size = static_cast<BlockId>(chain.blocks.size());
  for (FactorId id = begin; id < net->num_factors(); ++id) {
    if (!net->group(id).name.empty()) continue;
    BlockId first = size, last = -1;
    for (const BlockId block : net->factor(id).blocks) {
      if (block < front || block >= front + size) continue;
      first = std::min(first, block - front);
      last = std::max(last, block - front);
    }
    FactorGroup group = last <= 0 ? names.prior : names.group;
    const auto rows = static_cast<std::size_t>(net->factor(id).factor->residual_size());
    if (group.rows.size() != rows) group.rows.clear();
    net->Tag(id, group, chain.t_mid_s[static_cast<std::size_t>(last < 0 ? 0 : first)]);
  }
}

/// Lets the model add its factors. Returns false if it leaves the chain as it is.
bool AddOwn(const ProcessModel& model, const ProcessChain& chain, const ChainNames& names,
            Network* net) {
  const FactorId begin = net->num_factors();
  const bool own = model(chain, net);
  if (!own && net->num_factors() > begin) {
    throw InvalidInput("process model of '" + chain.name +
                       "' added factors but returned false: return true to replace the process");
  }
  TagOwnFactors(chain, names, begin, net);
  return own;
}

}  // namespace

Block<Vec<3>> ProcessChain::At(double t_s) const { return blocks[NodeBefore(t_begin_s, t_s)]; }

Eigen::Vector3d SumProcesses(const Network& net, const std::vector<ProcessChain>& chains,
                             double t_s) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const ProcessChain& chain : chains) sum += net.Value(chain.At(t_s));
  return sum;
}

std::vector<ConstantInterval> IntervalsOverNodes(const std::vector<double>& node_t_s,
                                                 double length_s) {
  std::vector<ConstantInterval> intervals{{node_t_s.front(), 0.0}};
  for (std::size_t k = 1; k + 1 < node_t_s.size(); ++k) {
    const bool next_too_late = node_t_s[k + 1] > intervals.back().t_begin_s + length_s + kSameTimeS;
    if (next_too_late) intervals.push_back({node_t_s[k], 0.0});
  }
  for (std::size_t k = 0; k < intervals.size(); ++k) {
    const double end_s = k + 1 < intervals.size() ? intervals[k + 1].t_begin_s : node_t_s.back();
    intervals[k].t_mid_s = 0.5 * (intervals[k].t_begin_s + end_s);
  }
  return intervals;
}

std::vector<ConstantInterval> IntervalsOverEpochs(const std::vector<double>& t_s, double length_s) {
  std::vector<ConstantInterval> intervals;
  for (const double t : t_s) {
    const bool next = intervals.empty() || t > intervals.back().t_begin_s + length_s - kSameTimeS;
    if (next) intervals.push_back({t, t});
    intervals.back().t_mid_s = 0.5 * (intervals.back().t_begin_s + t);
  }
  return intervals;
}

ProcessChain AddProcessChain(const BiasProcess& process,
                             const std::vector<ConstantInterval>& intervals,
                             const ChainNames& names, const Eigen::Vector3d& start, Network* net,
                             const ProcessModel& model) {
  const bool constant = process.type == BiasProcess::Type::kRandomConstant;
  ProcessChain chain;
  chain.name = names.name;
  chain.process = process;
  for (std::size_t k = 0; k < intervals.size(); ++k) {
    const ConstantInterval& interval = intervals[k];
    chain.t_begin_s.push_back(interval.t_begin_s);
    chain.t_mid_s.push_back(interval.t_mid_s);
    chain.blocks.push_back(net->AddVector<3>(names.name + "/" + std::to_string(k), start));
    net->SetLabel(
        chain.blocks.back().id,
        {names.quantity + (constant ? " (constant)" : ""), names.components, names.unit,
         names.per_si, constant ? std::numeric_limits<double>::quiet_NaN() : interval.t_mid_s});
  }
  if (!model || !AddOwn(model, chain, names, net))
    AddFirstOrder(chain, intervals.front(), names, net);
  return chain;
}

}  // namespace dn
