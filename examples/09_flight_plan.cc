// A flight plan: how well its lines would determine the boresight.
//
// A plan is poses and laser vectors. The sensor readings follow from the poses; nothing is
// simulated or solved. Prints the sigmas for a line flown both ways, and with a cross line.
#include <dn/builder/build.h>
#include <dn/solvers/marginals.h>

#include <cmath>
#include <cstdio>
#include <vector>

constexpr double kStep_s = 0.05, kSpeed_mps = 60.0, kHeight_m = 400.0;
constexpr const char* kSensors = R"(
imu: {grade: apx15}
gnss: {lever_arm_m: [0.4, -0.1, -1.1]}
lidar: {R_sensor_to_body: [[0, 1, 0], [0, 0, 1], [1, 0, 0]], scan_axis: [0, 1, 0],
        nadir_axis: [1, 0, 0], sigma_p_m: 0.05}
)";

/// Returns poses along legs of seconds and degrees per second, with coordinated turns.
std::vector<dn::MapPose> Fly(const std::vector<Eigen::Vector2d>& legs) {
  const Eigen::Quaterniond q_enu_ned(0.0, std::sqrt(0.5), std::sqrt(0.5), 0.0);
  std::vector<dn::MapPose> poses;
  Eigen::Vector3d p(0.0, -1800.0, kHeight_m);
  double t_s = 100000.0, heading = 0.0, rate = 0.0;
  for (const Eigen::Vector2d& leg : legs) {
    for (double s = 0.0; s < leg[0]; s += kStep_s, t_s += kStep_s) {
      rate += (dn::kRadPerDeg * leg[1] - rate) * kStep_s / 3.0;
      const double roll = std::atan(kSpeed_mps * rate / dn::kStandardGravityMps2);
      const Eigen::Vector3d v_m(kSpeed_mps * std::sin(heading), kSpeed_mps * std::cos(heading), 0);
      poses.push_back(
          {t_s, q_enu_ned * dn::QuaternionFromRollPitchHeading({roll, 0.0, heading}), p, v_m});
      p += kStep_s * v_m;
      heading += kStep_s * rate;
    }
  }
  return poses;
}

/// Returns pairs for points on the ground. Each point is observed on two consecutive passes, at the
/// epochs when it is abeam.
std::vector<dn::LidarPair> Pairs(const std::vector<dn::MapPose>& poses,
                                 const dn::Mounting& mounting) {
  std::vector<dn::LidarPair> pairs;
  for (int k = 0; k < 400; ++k) {
    const Eigen::Vector3d ground(37 * k % 401 - 200, 5 * k - 1000, 20.0 * std::sin(k));
    dn::LidarPair pair;
    for (std::size_t i = 1; i < poses.size(); ++i) {
      const Eigen::Vector3d away = ground - poses[i].p_mb;
      const bool abeam =
          poses[i - 1].v_m.dot(ground - poses[i - 1].p_mb) > 0.0 && poses[i].v_m.dot(away) <= 0.0;
      if (!abeam || away.head<2>().norm() > 300.0) continue;
      pair.t_j_s = poses[i].t_s;
      pair.u_j_s = mounting.R_bs_nominal.transpose() * (poses[i].q_mb.conjugate() * away);
      if (pair.t_i_s > 0.0) pairs.push_back(pair);
      pair.t_i_s = pair.t_j_s;
      pair.u_i_s = pair.u_j_s;
    }
  }
  return pairs;
}

int main() {
  const std::vector<Eigen::Vector2d> both_ways{{60, 0}, {30, -3}, {90, 3}, {90, 0}};
  std::vector<Eigen::Vector2d> across = both_ways;
  across.insert(across.end(), {{90, 3}, {60, 0}});
  for (const auto& [name, legs] : {std::pair{"both ways", both_ways}, {"and across", across}}) {
    const dn::NetworkDesign design{.poses = Fly(legs)};
    dn::Flight plan;
    plan.config = dn::ParseFlightConfig(kSensors, ".");
    plan.frame = dn::LocalFrame({46.5 * dn::kRadPerDeg, 6.6 * dn::kRadPerDeg, 400.0});
    plan.pairs = dn::PairData{{}, Pairs(design.poses, plan.config.lidar->mounting)};
    dn::PlanMeasurements(design, {}, &plan);

    const dn::FlightNetwork network = dn::Build(plan, design);
    const Eigen::Vector3d sigma_deg =
        dn::kDegPerRad * dn::MarginalSigma(network.net(), network.calibration().boresight());
    std::printf("%-10s %4zu pairs, sigma of roll, pitch, yaw %.4f %.4f %.4f deg\n", name,
                plan.pairs->pairs.size(), sigma_deg.x(), sigma_deg.y(), sigma_deg.z());
  }
  return 0;
}
