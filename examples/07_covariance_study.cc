// A study before any measurement: the best place for the fourth station of a range network.
//
// A covariance needs only geometry and noise. The network contains the planned position and the
// planned distances; the measured values are those that the plan predicts, and nothing is solved.
// Prints the sigmas of the position for each candidate, and the best one.
#include <dn/network.h>
#include <dn/solvers/marginals.h>

#include <cstdio>
#include <vector>

int main() {
  const Eigen::Vector3d planned_m(40.0, 40.0, 90.0);
  dn::Network plan;
  const auto antenna = plan.AddVector<3>("antenna", planned_m);
  const auto range = [&](dn::Network& net, const Eigen::Vector3d& station_m) {
    const double distance_m = (planned_m - station_m).norm();
    net.Add([=](const auto& p) { return (p - station_m).norm() - distance_m; },
            dn::Noise<1>::Sigma(0.02), antenna);
  };
  range(plan, {0.0, 0.0, 0.0});
  range(plan, {100.0, 0.0, 0.0});
  range(plan, {0.0, 100.0, 5.0});

  const std::vector<Eigen::Vector3d> candidates_m{
      {100.0, 100.0, 0.0}, {40.0, 40.0, 0.0}, {500.0, 40.0, 90.0}, {40.0, -300.0, 0.0}};
  double best_m = 1e9;
  Eigen::Vector3d best_station_m = candidates_m[0];
  for (const Eigen::Vector3d& station_m : candidates_m) {
    dn::Network net = plan;
    range(net, station_m);
    const Eigen::Vector3d sigma_m = dn::MarginalSigma(net, antenna);
    std::printf("station at %4.0f %4.0f %3.0f  sigma %.3f %.3f %.3f m\n", station_m.x(),
                station_m.y(), station_m.z(), sigma_m.x(), sigma_m.y(), sigma_m.z());
    if (sigma_m.norm() < best_m) {
      best_m = sigma_m.norm();
      best_station_m = station_m;
    }
  }
  std::printf("best at %.0f %.0f %.0f\n", best_station_m.x(), best_station_m.y(),
              best_station_m.z());
  return 0;
}
