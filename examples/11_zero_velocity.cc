// Zero velocity in a measured flight: a small aircraft that stands still before and after the
// flight.
//
// The aircraft counts as at rest if specific force and angular rate hardly vary. GNSS is withheld
// in the last minute. Prints the position errors there, without and with the factors, to show their
// benefit. The flight is thor75 of docs/validation/real-data.md; the example needs its folder.
#include <dn/imu/imu_data.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "withheld_gnss.h"

/// Returns the standard deviation of a reading within a second of t_s, its three axes combined.
double Scatter(const dn::ImuData& imu, double t_s, Eigen::Vector3d dn::ImuSample::*reading) {
  const auto [first, last] = dn::SampleRange(imu, t_s - 1.0, t_s + 1.0);
  const auto n = static_cast<double>(last - first);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (std::size_t k = first; k < last; ++k) mean += imu.samples[k].*reading / n;
  double variance = 0.0;
  for (std::size_t k = first; k < last; ++k)
    variance += (imu.samples[k].*reading - mean).squaredNorm() / n;
  return std::sqrt(variance);
}

/// At rest, this aircraft has 0.03 to 0.05 m/s^2 and 0.3 to 1 deg/s. Moved by hand or in flight, it
/// has at least 0.5 m/s^2 and 3 deg/s. Few readings lie in between.
bool IsAtRest(const dn::ImuData& imu, double t_s) {
  return Scatter(imu, t_s, &dn::ImuSample::f_b_mps2) < 0.1 &&
         Scatter(imu, t_s, &dn::ImuSample::w_ib_b_radps) < 1.5 * dn::kRadPerDeg;
}

int main() {
  const std::optional<dn::Flight> flight = ReadMeasured("thor75");
  if (!flight) return 0;
  const double end_s = flight->gnss->epochs.back().t_s;
  const dn::TimeInterval last_minute{end_s - 55.0, end_s};
  AdjustWithheld("inertial data alone", *flight, last_minute, [](dn::FlightNetwork&) {});

  int nodes_at_rest = 0;
  const auto stand_still = [&](dn::FlightNetwork& network) {
    for (const dn::NodeBlocks& node : network.nodes()) {
      if (!IsAtRest(*flight->imu, node.t_s)) continue;
      network.net().Add([](const auto& v_m) { return v_m.eval(); }, dn::Noise<3>::Sigma(0.02),
                        node.v_m);
      ++nodes_at_rest;
    }
  };
  AdjustWithheld("with zero velocity ", *flight, last_minute, stand_still);
  std::printf("%d nodes at rest\n", nodes_at_rest);
  return 0;
}
