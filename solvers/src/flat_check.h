#pragma once

#include <dn/network.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn {

/// The values of all blocks of a network, to go back to.
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

/// Finds unknowns that a solution has moved to where nothing depends on them any more, as the rate
/// of an exponential that has died away: the cost is flat there, but it is no solution.
class FlatCheck {
 public:
  /// Takes the values of the network as those that the solution starts from.
  explicit FlatCheck(const Network& network);

  /// The name of an unknown whose influence (length of its column of the Jacobian) has shrunk to
  /// nothing since the start, and too much to come back: moved to where it was, it would not change
  /// the residuals to first order. Empty where there is none.
  std::string FindFlat(const Network& network) const;

  const NetworkValues& initial() const { return initial_; }

 private:
  NetworkValues initial_;
  std::vector<Eigen::VectorXd> influence_;
};

}  // namespace dn
