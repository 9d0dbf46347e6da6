#pragma once

#include <dn/diagnosis/diagnosis.h>
#include <dn/diagnosis/gap_output.h>
#include <dn/geo/local_frame.h>

#include <limits>

namespace dn::testing {

inline Eigen::Vector3d Mdeg(double roll, double pitch, double yaw) {
  return 1e-3 / kDegPerRad * Eigen::Vector3d(roll, pitch, yaw);
}

inline GapCause LeverArmCause() {
  GapCause cause;
  cause.effect = "gnss_lever_arm";
  cause.unit = "m";
  cause.log_evidence = 45.25;
  cause.posterior = 0.97;
  cause.p_value = 1e-9;
  cause.estimate = Eigen::Vector3d(0.1, 0.0, -0.05);
  cause.sigma = Eigen::Vector3d(0.004, 0.004, 0.006);
  cause.absorbed_fraction = 0.98;
  cause.boresight_rad = Mdeg(3.0, -4.0, 14.0);
  cause.inseparable_from = {"lidar_lever_arm"};
  cause.held_out_gain_nats = 12.5;
  return cause;
}

inline GapCause StepCause() {
  GapCause cause;
  cause.effect = "boresight_step";
  cause.unit = "deg";
  cause.times.t0_s = 381500.0;
  cause.estimate = Eigen::Vector3d(0.01, 0.0, 0.0);
  cause.sigma = Eigen::Vector3d(0.001, 0.001, 0.002);
  return cause;
}

inline GapCause ProcessCause() {
  GapCause cause;
  cause.effect = "gyro_bias_process";
  cause.unit = "deg/h";
  cause.estimate = Eigen::Vector2d(0.3, 90.0);
  cause.sigma = Eigen::Vector2d(0.05, 30.0);
  return cause;
}

/// Returns the diagnosis of a flight with a wrong antenna position, with every number filled in.
inline GapDiagnosis LeverArmDiagnosis() {
  GapDiagnosis d;
  d.flight = "somewhere";
  d.detected = true;
  d.p_value = 0.002;
  d.size = {0.03, -0.001, 0.004, 0.036};
  d.user_units.p2p_excess_m = 0.012;
  d.user_units.boresight_inconsistency_rad = Mdeg(3.1, 0, 0).x();
  d.user_units.gh_minus_dn_rad = Mdeg(1.0, 2.0, 3.0);
  d.where = {{"lidar", "p2p", "strip pair 1-2, scan angle 20..30 deg", 8.5, 0.001},
             {"gnss", "position up", "0.01..0.02 Hz", 5.5, 0.02}};
  d.causes = {LeverArmCause(), StepCause(), ProcessCause()};
  d.discrepancies = {{"laser vectors by strip", 3.5, 0.25, std::nullopt, std::nullopt},
                     {"GNSS oscillation", 0.1, 0.01, 42.4, std::nullopt},
                     {"boresight that settles", -0.5, 0.005, std::nullopt, 50.0}};
  d.verdict.kind = GapVerdictKind::kIdentified;
  d.verdict.effects = {"gnss_lever_arm"};
  d.verdict.credible_set = {"gnss_lever_arm"};
  GapShrinkage shrinkage;
  shrinkage.fraction = 0.97;
  shrinkage.interval_low = 0.9;
  shrinkage.interval_high = 0.99;
  shrinkage.share_of_reachable = 0.95;
  shrinkage.before = {0.002, 0.03, 0.092, std::nullopt, Mdeg(200, 30, 350), Mdeg(1, 1, 3)};
  shrinkage.after = {0.41, 0.001, 0.041, std::nullopt, Mdeg(203, 26, 364), Mdeg(1, 1, 3.5)};
  d.shrinkage = shrinkage;
  DetectionLimit clock{"gnss_time_offset", "s", 0.0012, std::nullopt, Mdeg(0.2, 7, 5.9), {}};
  DetectionLimit cone{"lidar_scan_cone",
                      "deg",
                      std::numeric_limits<double>::infinity(),
                      std::nullopt,
                      Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()),
                      {"boresight"}};
  DetectionLimit range{"lidar_range_scale", "ppm", 40.0, 60.0, Mdeg(0.1, 0, 0), {}};
  d.could_still_hide = {range, clock, cone};
  d.fingerprint = {{"lidar p2p, strip pair 1-2, mean", 5.0, 1.0, 0.5, 4.8, 0.6},
                   {"gnss position up, lag 1", 0.1, 0.0, 0.2, std::nullopt, std::nullopt}};
  d.validity.observations = 4321;
  d.validity.replicates = 500;
  d.validity.simulated_replicates = 24;
  d.validity.tests = 77;
  d.validity.aa_p_value = 0.6;
  d.validity.notes = {"one note"};
  d.timings_s = {{"twins", 12.5}};
  d.verdict.text = VerdictSentence(d);
  return d;
}

}  // namespace dn::testing
