// A user's own factor: a laser return on a known plane, and the boresight from such returns. A
// class suits a factor that several programs use; a function given to Add does the same.
//
// Prints the error of the estimate and its three standard deviations.
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <cstdio>
#include <string>

/// r = (n_m . (p_mb + R_mb R_bs x_s) - d) / sigma      [1], unitless; n_m unit, x_s, d, sigma in m
struct PointOnPlane : dn::AutoFactor<PointOnPlane, 1, dn::Rotation, dn::Vec<3>, dn::LeftRotation> {
  Eigen::Vector3d x_s, n_m;
  double d_m, sigma_m;

  template <class T>
  bool Residual(const T* q_mb_data, const T* p_mb_data, const T* q_bs_data, T* r) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q_mb(q_mb_data), q_bs(q_bs_data);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> p_mb(p_mb_data);
    r[0] = (n_m.cast<T>().dot(p_mb + q_mb * (q_bs * x_s.cast<T>())) - d_m) / sigma_m;
    return true;
  }
};

int main() {
  const Eigen::Quaterniond q_bs_true = dn::Exp(Eigen::Vector3d(0.003, -0.005, 0.008));
  dn::Network net;
  const auto q_bs = net.AddLeftRotation("boresight", Eigen::Quaterniond::Identity());

  for (int i = 0; i < 6; ++i) {  // six known poses, each with one return on each of three planes
    const Eigen::Quaterniond q(Eigen::AngleAxisd(i, Eigen::Vector3d::UnitZ()));
    const Eigen::Vector3d p(100.0 * i, 50.0, 800.0);
    const auto q_mb = net.AddRotation("q/" + std::to_string(i), q);
    const auto p_mb = net.AddVector<3>("p/" + std::to_string(i), p);
    net.Hold(q_mb);
    net.Hold(p_mb);
    for (int axis = 0; axis < 3; ++axis) {
      PointOnPlane f;
      f.x_s = Eigen::Vector3d(60.0 * axis - 40.0, 30.0 - 10.0 * i, 790.0);
      f.n_m = Eigen::Vector3d::Unit(axis);
      f.d_m = f.n_m.dot(p + q * (q_bs_true * f.x_s));
      f.sigma_m = 0.03;
      net.Add(f, q_mb, p_mb, q_bs);
    }
  }

  const dn::SolveSummary summary = dn::Solve(net);
  const Eigen::Vector3d sigma_rad = dn::MarginalSigma(net, q_bs);
  const double error_rad = dn::Log(net.Value(q_bs) * q_bs_true.conjugate()).norm();
  std::printf("converged %d, boresight error %.1e rad, sigma %.1e %.1e %.1e rad\n",
              summary.converged, error_rad, sigma_rad.x(), sigma_rad.y(), sigma_rad.z());
  return summary.converged ? 0 : 1;
}
