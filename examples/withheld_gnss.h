#pragma once

#include <dn/diagnosis/solution.h>
#include <dn/files/flight.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

/// Reads a measured flight by the name of its folder. Prints a note and returns nullopt if the data
/// are absent.
inline std::optional<dn::Flight> ReadMeasured(const std::string& name) {
  const std::filesystem::path folder = std::filesystem::path(DN_SHARED_DATA_DIR) / "data" / name;
  if (std::filesystem::exists(folder)) return dn::ReadFlight(folder, {.imu = true, .gnss = true});
  std::printf("measured flight absent: %s\n", folder.c_str());
  return {};
}

/// Adjusts a flight with GNSS withheld in an interval and with a user's own factors. Prints the
/// errors of the positions there, measured by the withheld GNSS, and their sigmas, m.
inline dn::Solution AdjustWithheld(const char* name, const dn::Flight& flight,
                                   const dn::TimeInterval& interval,
                                   const std::function<void(dn::FlightNetwork&)>& add_factors) {
  std::vector<dn::GnssEdge> withheld;
  dn::AdjustOptions options;
  options.with_pairs = false;
  options.customise = [&](dn::FlightNetwork& network) {
    for (const dn::GnssEdge& edge : network.gnss().edges()) {
      const double t_s = network.trajectory().node_times()[edge.node];
      if (t_s < interval.t0_s || t_s > interval.t1_s) continue;
      network.net().SetActive(edge.position, false);
      if (edge.velocity >= 0) network.net().SetActive(edge.velocity, false);
      withheld.push_back(edge);
    }
    add_factors(network);
  };
  dn::Solution solution(flight, options);

  double error2 = 0.0, sigma2 = 0.0, largest = 0.0;
  for (const dn::GnssEdge& edge : withheld) {
    const dn::MapPose pose = solution.network().trajectory().NodePose(edge.node);
    const Eigen::Vector3d antenna_m = pose.p_mb + pose.q_mb * flight.config.gnss->lever_arm_b_m;
    const Eigen::Vector3d error_m = antenna_m - flight.gnss->epochs[edge.epoch].p_m;
    error2 += error_m.squaredNorm();
    largest = std::max(largest, error_m.norm());
    sigma2 += solution.trajectory().sigma[edge.node].position_enu_m.squaredNorm();
  }
  const auto n = static_cast<double>(withheld.size());
  std::printf("%s: %zu epochs withheld, error %.3f m rms, %.3f m at most, sigma %.3f m\n", name,
              withheld.size(), std::sqrt(error2 / n), largest, std::sqrt(sigma2 / n));
  return solution;
}
