#include <dn/builder/node_grid.h>
#include <dn/builder/process_chain.h>
#include <dn/factors/bias_process.h>
#include <dn/factors/prior.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dn {
namespace {

constexpr double kSameTimeS = 1e-6;

double PriorSigma(const BiasProcess& process, const ConstantInterval& first) {
  if (process.type != BiasProcess::Type::kRandomWalk) return process.sigma;
  return process.sigma * std::sqrt(std::max(first.t_mid_s - first.t_begin_s, 1e-3));
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
                             const ChainNames& names, const Eigen::Vector3d& start, Network* net) {
  const bool constant = process.type == BiasProcess::Type::kRandomConstant;
  ProcessChain chain;
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
  const Noise<3> first = Noise<3>::Sigma(PriorSigma(process, intervals.front()));
  net->Tag(net->Add(PriorVector<3>(Eigen::Vector3d::Zero(), first), chain.blocks.front()),
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
  return chain;
}

}  // namespace dn
