#pragma once

#include <dn/calibration/candidate_effects.h>
#include <dn/flight/flight_config.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <string>
#include <vector>

namespace dn::internal {

/// What an effect is made of at one end of a pair.
struct PairEnd {
  double t_s = 0.0;
  Eigen::Matrix3d J_r_u;   ///< d residual / d laser vector in body axes
  Eigen::Vector3d J_r_t;   ///< d residual / d tag: of a late tag of this end (tag = t + dt)
  Eigen::Vector3d u_b;     ///< laser vector in body, boresight applied, m
  Eigen::Vector3d u_s;     ///< in the sensor frame, m
  Eigen::Vector3d axis_b;  ///< scan axis in body
  double scan_angle_rad = 0.0;
};

struct PairEnds {
  FactorId factor = -1;
  PairEnd i, j;
};

/// t_s, u_s and the angle of the scan; the derivatives are left to the caller.
PairEnd MakePairEnd(const LidarConfig& lidar, const Eigen::Quaterniond& q_boresight, double t_s,
                    const Eigen::Vector3d& u_s);

/// A constant error of the time tags, and one of the lever arm.
EffectModel TimeOffsetModel(const std::vector<PairEnds>& pairs);
EffectModel LeverArmModel(const std::vector<PairEnds>& pairs);

/// One effect, with its usual size in `unit`.
CandidateEffect MakeEffect(const std::string& name, const std::string& unit, double unit_si,
                           int components, double typical, const std::string& remedy,
                           EffectModel model);
CandidateEffect TimeOffset(const std::string& remedy, EffectModel model);
CandidateEffect LeverArm(const std::string& remedy, EffectModel model);

/// Clock, ranges and scan angles.
void AddEffectsOfScanner(const std::vector<PairEnds>& pairs, std::vector<CandidateEffect>* effects);

/// Drift of the mount, and steps of it between two strips.
void AddMovesOfMount(const std::vector<PairEnds>& pairs, const std::vector<StripInterval>& strips,
                     std::vector<CandidateEffect>* effects);

}  // namespace dn::internal
