#pragma once

#include <dn/factor_group.h>
#include <dn/imu/imu_model.h>
#include <dn/network.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// A stretch of time over which a process is held: one block, whose value is that of the process at
/// t_mid_s.
struct HeldInterval {
  double t_begin_s = 0.0;
  double t_mid_s = 0.0;
};

/// One process on three axes as blocks: a single one for a random constant, else one per interval.
struct ProcessChain {
  BiasProcess process;
  std::vector<double> t_begin_s;  ///< start of each interval
  std::vector<double> t_mid_s;
  std::vector<Block<Vec<3>>> blocks;

  /// The block that holds at t_s.
  Block<Vec<3>> At(double t_s) const;
};

/// Sum of the processes that hold at t_s.
Eigen::Vector3d SumOfProcesses(const Network& net, const std::vector<ProcessChain>& chains,
                               double t_s);

/// Intervals from node to node, none longer than length_s unless two nodes are further apart.
std::vector<HeldInterval> HoldOverNodes(const std::vector<double>& node_t_s, double length_s);

/// Intervals of measurements at single epochs: the epochs that are less than length_s after an
/// interval's first, at least that one. The middle is that of its first and last epoch.
std::vector<HeldInterval> HoldOverEpochs(const std::vector<double>& t_s, double length_s);

/// What the blocks and factors of a chain are called.
struct ChainNames {
  std::string name;  ///< of block k: name/k
  std::string quantity;
  std::vector<std::string> components;
  std::string unit;
  double per_si = 1.0;
  FactorGroup group;  ///< of its steps
  FactorGroup prior;  ///< of what bounds its first block
};

/// Adds a chain: the blocks, the prior of the first one and the steps between them, exact at every
/// length (GaussMarkovEdge, RandomWalkEdge). The first block of a random walk is bounded by its
/// growth over half an interval. All blocks start at `start`.
ProcessChain AddProcessChain(const BiasProcess& process, const std::vector<HeldInterval>& intervals,
                             const ChainNames& names, const Eigen::Vector3d& start, Network* net);

}  // namespace dn
