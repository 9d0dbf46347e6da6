// Unknown planes, scanned from known stations by one instrument with an unknown range offset. A
// plane is a block kind of its own: unit normal and distance.
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <random>
#include <vector>

#include "check.h"

namespace {

/// n . x = d, stored as n and d. The normal moves along two axes at right angles to it.
struct Plane {
  static constexpr int kSize = 4, kTangentSize = 3;

  template <class T>
  static Eigen::Matrix<T, 3, 2> Axes(const Eigen::Matrix<T, 3, 1>& n) {
    const Eigen::Matrix<T, 3, 1> from = Eigen::Matrix<T, 3, 1>::Unit(n[0] * n[0] < T(0.5) ? 0 : 1);
    Eigen::Matrix<T, 3, 2> axes;
    axes.col(0) = n.cross(from).normalized();
    axes.col(1) = n.cross(axes.col(0));
    return axes;
  }
  template <class T>
  static void Plus(const T* x, const T* d, T* x_plus_d) {
    const Eigen::Matrix<T, 3, 1> n(x[0], x[1], x[2]);
    Eigen::Map<Eigen::Matrix<T, 3, 1>> moved(x_plus_d);
    moved = (n + Axes(n) * Eigen::Matrix<T, 2, 1>(d[0], d[1])).normalized();
    x_plus_d[3] = x[3] + d[2];
  }
  static void Minus(const double* y, const double* x, double* y_minus_x) {
    const Eigen::Vector3d n(x[0], x[1], x[2]), m(y[0], y[1], y[2]);
    const Eigen::Vector2d turn = Axes(n).transpose() * m / n.dot(m);
    y_minus_x[0] = turn.x();
    y_minus_x[1] = turn.y();
    y_minus_x[2] = y[3] - x[3];
  }
};

constexpr double kSigma_m = 0.005, kOffset_m = 0.12;

}  // namespace

int main() {
  std::mt19937 rng(5);
  std::normal_distribution<double> normal;
  const std::vector<Eigen::Vector3d> stations{{0, 0, 1.5}, {8, 2, 1.5}, {3, 7, 2.0}};
  dn::Network net;
  const auto offset = net.AddScalar("range offset", 0.0);
  for (int axis = 0; axis < 3; ++axis) {
    for (const double d_m : {-2.0, 12.0}) {  // the walls, floor and ceiling of a room
      const Eigen::Vector3d n = Eigen::Vector3d::Unit(axis);
      const std::string name = "plane " + std::to_string(axis) + (d_m < 0.0 ? " low" : " high");
      const auto plane = net.AddBlock<Plane>(
          name, Eigen::Vector4d(n.x() + 0.02, n.y() - 0.02, n.z() + 0.01, d_m + 0.3));
      for (const Eigen::Vector3d& station : stations) {
        for (int k = 0; k < 30; ++k) {
          Eigen::Vector3d u(normal(rng), normal(rng), normal(rng));
          u[axis] = d_m < 0.0 ? -1.0 - std::abs(u[axis]) : 1.0 + std::abs(u[axis]);
          u.normalize();
          const double range_m = (d_m - station[axis]) / u[axis];
          const double measured_m = range_m - kOffset_m + kSigma_m * normal(rng);
          net.Add(
              [=](const auto& p, const auto& o) {
                const auto n = p.template head<3>();
                return (p[3] - n.dot(station)) / n.dot(u) - measured_m - o;
              },
              dn::Noise<1>::Sigma(kSigma_m), plane, offset);
        }
      }
    }
  }
  const dn::SolveSummary report = dn::Solve(net);
  bool good = report.converged && Between("sigma0", report.adjusted.sigma0(), 0.85, 1.15);
  const double sigma_m = dn::MarginalSigma(net, offset);
  good = Agrees("offset", net.Value(offset), kOffset_m, sigma_m) && good;
  return Between("sigma of the offset, m", sigma_m, 1e-5, kSigma_m) && good ? 0 : 1;
}
