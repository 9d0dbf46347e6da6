#pragma once

#include <Eigen/Cholesky>
#include <Eigen/Core>

#include "gauss_helmert_pair.h"

namespace dn::fixed_trajectory_internal {

/// Weighted sums over all pairs of a Gauss-Helmert adjustment at its current state.
struct NormalSums {
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();  ///< A^T S A of the boresight
  Eigen::Vector3d g = Eigen::Vector3d::Zero();  ///< A^T S w~
  Eigen::MatrixXd N_laser;                      ///< A^T S A of the laser unknowns
  Eigen::MatrixXd cross;    ///< rows of the laser unknowns, columns of the boresight
  Eigen::VectorXd g_laser;  ///< A^T S w~ of the laser unknowns
  double chi2 = 0.0;
  double chi2_conditions = 0.0;

  explicit NormalSums(Eigen::Index laser = 0);

  /// Adds the laser unknowns of a pair. A is d w / d boresight, w is w~.
  void AddLaser(const LaserColumns& columns, const Eigen::Matrix3d& S, const Eigen::Matrix3d& A,
                const Eigen::Vector3d& w);
  void operator+=(const NormalSums& other);
};

/// Changes of the boresight and the laser unknowns.
struct UnknownsChange {
  Eigen::Vector3d boresight = Eigen::Vector3d::Zero();
  Eigen::VectorXd laser;
};

/// Solves the normal equations with the laser unknowns eliminated. The sums must outlive it.
class NormalSolver {
 public:
  explicit NormalSolver(const NormalSums& sums);

  /// Returns the normal matrix of the boresight alone.
  const Eigen::Matrix3d& N() const { return N_; }
  UnknownsChange Solve() const;
  /// Returns the covariance of the laser unknowns; 0 x 0 without any.
  Eigen::MatrixXd LaserCovariance() const;

 private:
  const NormalSums& sums_;
  Eigen::Matrix3d N_;
  Eigen::LLT<Eigen::MatrixXd> laser_;
};

}  // namespace dn::fixed_trajectory_internal
