#pragma once

#include <dn/builder/flight_network.h>
#include <dn/solvers/linearized_network.h>

#include <Eigen/Core>
#include <string>
#include <vector>

namespace dn::internal {

/// A quadratic form of the residuals: those with the same label are summed, the sums squared.
struct ResidualComponent {
  std::string name;
  std::string group;
  std::vector<int> label;  ///< per row of the linearised network; -1: takes no part
  int labels = 0;
  std::vector<std::string> label_name;

  double Energy(const Eigen::Ref<const Eigen::VectorXd>& residual) const;
  /// Sums of the rows of X by label: labels x columns.
  Eigen::MatrixXd SumByLabel(const Eigen::MatrixXd& X) const;
};

/// Every residual by itself, per sensor, and per axis of it: their mean squares.
std::vector<ResidualComponent> GroupComponents(const FlightNetwork& network,
                                               const LinearizedNetwork& linearized);

/// Residuals of an axis summed over windows of time, and over pairs of strips.
std::vector<ResidualComponent> CommonErrorComponents(const FlightNetwork& network,
                                                     const LinearizedNetwork& linearized);

}  // namespace dn::internal
