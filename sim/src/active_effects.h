#pragma once

#include <dn/files/effect_times.h>
#include <dn/files/flight_config.h>
#include <dn/geo/local_frame.h>
#include <dn/imu/imu_data.h>
#include <dn/lidar/pairs.h>
#include <dn/sim/own_errors.h>
#include <dn/sim/scenario.h>
#include <dn/sim/truth.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace dn {

/// First and last true epoch of pairs or strips.
struct LidarSpan {
  double first_s = 0.0;
  double last_s = 0.0;
  double middle_s() const { return 0.5 * (first_s + last_s); }
};

/// Returns the span from the first to the last epoch, 0 to 0 without any.
LidarSpan LidarEpochSpan(const std::vector<StripInterval>& strips);
LidarSpan LidarEpochSpan(const std::vector<LidarPair>& pairs);

/// Rotates the vector u by the angle towards the axis (a unit vector).
Eigen::Vector3d TurnedTowardAxis(const Eigen::Vector3d& axis, double angle_rad,
                                 const Eigen::Vector3d& u);

/// Shift of the time tags relative to true time, with the entry of the scenario that causes it.
struct TagShift {
  std::string effect;
  FileLocation where;
  std::function<double(double t_s)> shift_s;
};

/// Time span without data, with the entry of the scenario that causes it.
struct DataGap {
  std::string effect;
  FileLocation where;
  EffectTimes times;
};

/// Actions of the effects of a scenario, sorted by the place in the simulation where they apply.
/// They are created once, before the simulation. The functions of a list apply one after the other,
/// each to the result of the one before. Functions with random numbers must be called once per
/// epoch, in time order.
struct ActiveEffects {
  /// Gravity in addition to the normal one at a point, in m, m/s^2.
  std::vector<std::function<Eigen::Vector3d(const Eigen::Vector3d& p_m, const LocalFrame& frame)>>
      gravity_m;

  /// Errors of the triads; `truth` is the true sample.
  std::vector<std::function<void(const ImuSample& truth, ImuSample* sample)>> triads;
  /// Mean over the next sample interval of a bias process in addition to the assumed ones, SI.
  std::vector<std::function<Eigen::Vector3d()>> gyro_bias, accel_bias;
  double gyro_noise_ratio = 1.0;   ///< white noise divided by the assumed one
  double accel_noise_ratio = 1.0;  ///< white noise divided by the assumed one
  /// Noise in addition to the assumed one, added to a sample.
  std::vector<std::function<void(ImuSample* sample)>> imu_noise;
  std::vector<TagShift> imu_tags;
  std::vector<DataGap> imu_gaps;

  Eigen::Vector3d gnss_lever_arm_b_m = Eigen::Vector3d::Zero();  ///< true minus assumed value
  double gnss_noise_ratio = 1.0;
  /// Error of an antenna position at a true roll, east, north, up, m.
  std::vector<std::function<Eigen::Vector3d(double t_s, double roll_rad)>> antenna_enu_m;
  std::vector<TagShift> gnss_tags;
  double gnss_tag_drift = 0.0;  ///< of the tags relative to true time, from the first epoch on
  std::vector<DataGap> gnss_gaps;

  Eigen::Vector3d lidar_lever_arm_b_m = Eigen::Vector3d::Zero();  ///< true minus assumed value
  /// Error added to the rotation vector of the boresight.
  std::vector<std::function<Eigen::Vector3d(double t_s, const LidarSpan& span)>> boresight_rad;
  /// Rotation of the beam towards +scan_axis as a function of its scan angle, relative to the
  /// assumed beam.
  std::vector<std::function<double(double scan_angle_rad)>> scan_lean_rad;
  /// Measured laser vector for a true one in the sensor frame, at the true time t_s.
  std::vector<std::function<Eigen::Vector3d(const Eigen::Vector3d& u_s, double t_s)>> laser_vector;
  std::vector<std::function<double(double t_s, const LidarSpan& span)>> lidar_tag_shift_s;

  /// New sigma_p of a pair from the previous one, m.
  std::vector<std::function<double(double sigma_p_m, double mean_range_m)>> pair_sigma_m;
  /// Errors of a finished pair.
  std::vector<std::function<void(LidarPair* pair)>> pairs;
  /// Errors of all pairs together, applied after the errors of each pair.
  std::vector<std::function<void(PairData* pairs)>> all_pairs;

  /// Rotations that multiply the attitude of trajectory.out from the right.
  std::vector<Eigen::Quaterniond> trajectory_turn;
};

/// Returns the rotation towards +scan_axis of the beam that has the scan angle of u_s, rad.
double ScanLean(const ActiveEffects& effects, const LidarScenario& lidar,
                const Eigen::Vector3d& u_s);

/// Creates the effects of a scenario. The random numbers depend on the seed, the name of the
/// effect, and its index among the entries of that name. Without `noise` the stochastic effects are
/// omitted.
ActiveEffects MakeActiveEffects(const Scenario& scenario, std::uint64_t seed, bool noise);

/// Adds the errors of the caller to the lists, after the effects. Functions that need the true pose
/// keep a pointer to `truth`.
void AddOwnErrors(const OwnErrors& own, const std::shared_ptr<const TruthTrajectory>& truth,
                  ActiveEffects* active);

/// Throws InvalidConfig with the entry whose shift makes the tag at t_s not later than the tag at
/// before_s.
[[noreturn]] void RefuseStepBack(const std::vector<TagShift>& shifts, double before_s, double t_s);

/// Returns the time tag of the true time t_s.
double Tag(const std::vector<TagShift>& shifts, double t_s);

/// Returns true if t_s lies in one of the gaps.
bool InGap(const std::vector<DataGap>& gaps, double t_s);

}  // namespace dn
