// A user's project that uses only the installed package. It locates an antenna from distances to
// four ground stations with a custom factor class. Exits with 0 if the truth is recovered.
#include <dn/factor.h>
#include <dn/geo/local_frame.h>
#include <dn/network.h>
#include <dn/solvers/marginals.h>
#include <dn/solvers/solve.h>

#include <Eigen/Core>
#include <array>
#include <cstdio>

/// r = (|p_ma - s_m| - distance) / sigma      [1], unitless; all in m
struct Distance : dn::AutoFactor<Distance, 1, dn::Vec<3>> {
  Eigen::Vector3d s_m;
  double distance_m = 0.0;
  double sigma_m = 0.0;

  template <class T>
  bool Residual(const T* p_ma_data, T* r) const {
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> p_ma(p_ma_data);
    r[0] = ((p_ma - s_m.cast<T>()).norm() - distance_m) / sigma_m;
    return true;
  }
};

int main() {
  constexpr double kDegree = 3.14159265358979323846 / 180.0;
  const dn::LocalFrame frame({46.57 * kDegree, 6.52 * kDegree, 400.0});
  const Eigen::Vector3d truth_m = frame.ToMap({46.575 * kDegree, 6.53 * kDegree, 1200.0});
  const std::array<Eigen::Vector3d, 4> stations_m{
      {{0, 0, 0}, {2000, 0, 50}, {0, 2000, -30}, {2000, 2000, 10}}};

  dn::Network net;
  const auto p_ma = net.AddVector<3>("antenna", Eigen::Vector3d(900, 900, 500));
  for (const Eigen::Vector3d& station_m : stations_m) {
    Distance factor;
    factor.s_m = station_m;
    factor.distance_m = (truth_m - station_m).norm();
    factor.sigma_m = 0.02;
    net.Add(factor, p_ma);
  }

  const dn::SolveSummary summary = dn::Solve(net);
  const Eigen::Vector3d sigma_m = dn::MarginalSigma(net, p_ma);
  const double error_m = (net.Value(p_ma) - truth_m).norm();
  std::printf("converged %d, error %.1e m, sigma %.3f %.3f %.3f m\n", summary.converged, error_m,
              sigma_m.x(), sigma_m.y(), sigma_m.z());
  constexpr double kTolerance_m = 1e-6;  // without noise, only solver tolerances matter
  return summary.converged && error_m < kTolerance_m && sigma_m.allFinite() ? 0 : 1;
}
