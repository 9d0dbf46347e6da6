#pragma once

#include <dn/builder/calibration_blocks.h>
#include <dn/builder/trajectory_graph.h>
#include <dn/factor_group.h>
#include <dn/files/flight.h>
#include <dn/imu/preintegration.h>
#include <dn/network.h>

#include <map>
#include <memory>
#include <vector>

namespace dn {

/// The factors that a network of a flight made for its edges. A factor that the caller has replaced
/// (Network::ReplaceFactor) stays unchanged.
class MadeFactors {
 public:
  explicit MadeFactors(Network* net) : net_(*net) {}

  FactorId Add(std::shared_ptr<const FactorBase> factor, const std::vector<BlockId>& blocks,
               const FactorGroup& group, double t_s);

  /// Replaces a factor by the result of make(), which is called only if the caller has not replaced
  /// the factor.
  template <class Make>
  void Renew(FactorId id, const Make& make) {
    std::weak_ptr<const FactorBase>& made = made_[id];
    if (made.lock() != net_.factor(id).factor) return;
    std::shared_ptr<const FactorBase> factor = make();
    made = factor;
    net_.ReplaceFactor(id, std::move(factor));
  }

 private:
  Network& net_;
  std::map<FactorId, std::weak_ptr<const FactorBase>> made_;
};

/// The parts of a flight network to which edges are attached. All must outlive the edges.
struct EdgeContext {
  const Flight& flight;
  const CalibrationBlocks& calibration;
  const TrajectoryGraph& trajectory;
  const Network& net;
  MadeFactors& factors;
  PreintegrationNoise noise;
  int threads = 1;
};

}  // namespace dn
