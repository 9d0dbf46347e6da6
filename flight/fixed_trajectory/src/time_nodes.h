#pragma once

#include <Eigen/Core>
#include <vector>

#include "error_process.h"

namespace dn::internal {

/// Nodes in time, between which a function of time is linear in each strip. A strip with a single
/// node holds a constant.
class TimeNodes {
 public:
  /// Evenly in each strip; one in a strip that is much shorter than the spacing.
  /// epochs_s: where the function is needed. strip_begin_s: ascending; epochs before and after one
  /// of them belong to two strips. If empty, a pause of 5 s among the epochs parts two strips.
  /// Strips that are no further apart than the nodes become one.
  TimeNodes(std::vector<double> epochs_s, const std::vector<double>& strip_begin_s, int max_nodes);

  /// Nodes at given epochs, increasing, with the strip of each.
  TimeNodes(const std::vector<double>& t_s, const std::vector<int>& strip);

  struct Place {
    int node, next_node;  ///< the same in a strip with a single one
    double next;          ///< weight of next_node; that of node is 1 - next
  };
  Place At(double t_s) const;

  int size() const { return static_cast<int>(t_s_.size()); }

  /// Covariance of the nodes that follow a process by least squares.
  Eigen::MatrixXd Covariance(const ErrorProcess& process) const;

 private:
  struct Strip {
    double begin_s, end_s;
    int first, count;  // nodes
  };

  int Divide(const std::vector<double>& epochs_s, const std::vector<double>& strip_begin_s,
             double spacing_s);
  void Sample();

  std::vector<Strip> strips_;
  std::vector<double> t_s_;
  // A finer grid, and the nodes as linear functions of the values there.
  std::vector<double> sample_t_s_;
  std::vector<int> sample_strip_;
  Eigen::MatrixXd from_samples_;
};

}  // namespace dn::internal
