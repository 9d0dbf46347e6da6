#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// A copy of the values of all blocks of a network, for restoring them later.
class NetworkValues {
 public:
  explicit NetworkValues(const Network& network);
  void Restore(Network* network) const;
  const double* value(BlockId b) const {
    return values_.data() + first_[static_cast<std::size_t>(b)];
  }

 private:
  std::vector<std::size_t> first_;
  std::vector<double> values_;
};

/// Detects unknowns that the solution has moved to a plateau, where the residuals no longer depend
/// on them. An example is the rate of an exponential that has decayed: the cost is flat there, but
/// it is not a minimum.
class PlateauCheck {
 public:
  /// Stores the current values of the network as the initial values of the solution.
  explicit PlateauCheck(const Network& network);

  /// Returns the name of an unknown that has lost its influence since the start, or an empty
  /// string. The influence is the length of its Jacobian column. An unknown counts only if moving
  /// it back to its initial value would not change the residuals to first order.
  std::string FindPlateauUnknown(const Network& network) const;

  const NetworkValues& initial() const { return initial_; }

 private:
  NetworkValues initial_;
  std::vector<Eigen::VectorXd> influence_;
};

}  // namespace dn
