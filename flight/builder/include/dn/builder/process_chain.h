#pragma once

#include <dn/factor_group.h>
#include <dn/imu/imu_model.h>
#include <dn/network.h>

#include <Eigen/Core>
#include <functional>
#include <string>
#include <vector>

namespace dn {

/// A time interval over which a process is constant: one block with the value of the process at
/// t_mid_s.
struct ConstantInterval {
  double t_begin_s = 0.0;
  double t_mid_s = 0.0;
};

/// One process on three axes as blocks of a network: a single block for a random constant,
/// otherwise one per interval.
struct ProcessChain {
  std::string name;  ///< block k is called name/k
  BiasProcess process;
  std::vector<double> t_begin_s;  ///< start of each interval
  std::vector<double> t_mid_s;
  std::vector<Block<Vec<3>>> blocks;

  /// Returns the block of the interval that contains t_s.
  Block<Vec<3>> At(double t_s) const;
};

/// Returns the sum of the values of all chains at t_s.
Eigen::Vector3d SumProcesses(const Network& net, const std::vector<ProcessChain>& chains,
                             double t_s);

/// Returns intervals that begin and end at nodes, at most length_s long unless two neighbouring
/// nodes are further apart.
std::vector<ConstantInterval> IntervalsOverNodes(const std::vector<double>& node_t_s,
                                                 double length_s);

/// Returns intervals for measurements at single epochs. An interval contains its first epoch and
/// the later ones less than length_s after it. Its middle is the mean of its first and last epoch.
std::vector<ConstantInterval> IntervalsOverEpochs(const std::vector<double>& t_s, double length_s);

/// Names of the blocks and factor groups of a chain.
struct ChainNames {
  std::string name;  ///< block k is called name/k
  std::string quantity = {};
  std::vector<std::string> components = {};
  std::string unit = {};
  double per_si = 1.0;
  FactorGroup group = {};  ///< group of the factors between neighbouring blocks
  FactorGroup prior = {};  ///< group of the prior of the first block
};

/// Adds the factors of another process to the blocks of a chain: the prior of the first block and
/// the transitions between blocks. It may add blocks of its own, such as the rate of the error.
/// Returns false, without adding anything, to keep the first-order process of the chain.
using ProcessModel = std::function<bool(const ProcessChain& chain, Network* net)>;

/// Adds a chain: the blocks, the prior of the first block, and the transitions between neighbouring
/// blocks. The transitions are exact for every time step (GaussMarkovEdge, RandomWalkEdge). The
/// prior sigma of a random walk is its growth over half an interval. All blocks start at the value
/// `start`.
///
/// `model` can replace the prior and the transitions. Its factors get the groups of the chain
/// unless it tags them. A factor that has no block of the chain but the first counts as a prior.
/// Throws InvalidInput if it adds factors but returns false.
ProcessChain AddProcessChain(const BiasProcess& process,
                             const std::vector<ConstantInterval>& intervals,
                             const ChainNames& names, const Eigen::Vector3d& start, Network* net,
                             const ProcessModel& model = {});

}  // namespace dn
