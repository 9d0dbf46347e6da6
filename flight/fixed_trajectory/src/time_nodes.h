#pragma once

#include <Eigen/Core>
#include <vector>

#include "error_process.h"

namespace dn::fixed_trajectory_internal {

/// Nodes in time. A function is represented by its values at the nodes and is linear between them
/// within each strip. In a strip with a single node it is constant.
class TimeNodes {
 public:
  /// Places the nodes evenly within each strip, and one node in a strip much shorter than the
  /// spacing. `epochs_s` are the epochs at which the function is needed. `strip_begin_s`
  /// (ascending) separates epochs into strips. If it is empty, a pause of 5 s between epochs
  /// separates two strips. Strips that are closer together than the node spacing are merged.
  TimeNodes(std::vector<double> epochs_s, const std::vector<double>& strip_begin_s, int max_nodes);

  /// Places nodes at the given increasing epochs, with the strip of each.
  TimeNodes(const std::vector<double>& t_s, const std::vector<int>& strip);

  struct Place {
    int node, next_node;  ///< equal to `node` in a strip with a single node
    double next;          ///< weight of next_node; `node` has the weight 1 - next
  };
  Place At(double t_s) const;

  int size() const { return static_cast<int>(t_s_.size()); }

  /// Returns the covariance of the node values that fit a process by least squares.
  Eigen::MatrixXd Covariance(const ErrorProcess& process) const;

 private:
  struct Strip {
    double begin_s, end_s;
    int first, count;  // nodes of the strip
  };

  int Divide(const std::vector<double>& epochs_s, const std::vector<double>& strip_begin_s,
             double spacing_s);
  void Sample();

  std::vector<Strip> strips_;
  std::vector<double> t_s_;
  // A finer time grid, and the matrix that maps values on it to the nodes.
  std::vector<double> sample_t_s_;
  std::vector<int> sample_strip_;
  Eigen::MatrixXd from_samples_;
};

}  // namespace dn::fixed_trajectory_internal
