#pragma once

#include <dn/flight/effect_times.h>
#include <dn/flight/flight_config.h>
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

/// First and last true epoch of the pairs.
struct LidarSpan {
  double first_s = 0.0;
  double last_s = 0.0;
  double middle_s() const { return 0.5 * (first_s + last_s); }
};

LidarSpan SpanOf(const std::vector<StripInterval>& strips);
LidarSpan SpanOf(const std::vector<LidarPair>& pairs);

/// The vector turned by the angle toward the axis (a unit vector).
Eigen::Vector3d TurnedTowardAxis(const Eigen::Vector3d& axis, double angle_rad,
                                 const Eigen::Vector3d& u);

/// How much later the tags are than the true time, and which entry says so.
struct TagShift {
  std::string effect;
  FileLocation where;
  std::function<double(double t_s)> shift_s;
};

/// When there are no data, and which entry says so.
struct DataGap {
  std::string effect;
  FileLocation where;
  EffectTimes times;
};

/// What the effects of a scenario do, at each place where the simulation asks. Made once, before
/// anything is simulated. Functions of a list apply one after the other, each to what the one
/// before has left; those with random numbers are to be called once per epoch, in the order of
/// time.
struct ActiveEffects {
  /// Gravity beyond the normal one at a point, in m, m/s^2.
  std::vector<std::function<Eigen::Vector3d(const Eigen::Vector3d& p_m, const LocalFrame& frame)>>
      gravity_m;

  /// Errors of the triads, of a sample with the true one given.
  std::vector<std::function<void(const ImuSample& truth, ImuSample* sample)>> triads;
  /// Mean over the next sample interval of a bias process beyond the assumed ones, SI.
  std::vector<std::function<Eigen::Vector3d()>> gyro_bias, accel_bias;
  double gyro_noise_ratio = 1.0,
         accel_noise_ratio = 1.0;  ///< of the white noise to the assumed one
  /// Noise beyond the assumed one, added to a sample.
  std::vector<std::function<void(ImuSample* sample)>> imu_noise;
  std::vector<TagShift> imu_tags;
  std::vector<DataGap> imu_gaps;

  Eigen::Vector3d gnss_lever_arm_b_m = Eigen::Vector3d::Zero();  ///< beyond the assumed one
  double gnss_noise_ratio = 1.0;
  /// Error of an antenna position, east, north, up, m.
  std::vector<std::function<Eigen::Vector3d(double t_s)>> antenna_enu_m;
  std::vector<TagShift> gnss_tags;
  double gnss_tag_drift = 0.0;  ///< of the tags against true time, from the first epoch on
  std::vector<DataGap> gnss_gaps;

  Eigen::Vector3d lidar_lever_arm_b_m = Eigen::Vector3d::Zero();  ///< beyond the assumed one
  /// Added to the boresight's rotation vector.
  std::vector<std::function<Eigen::Vector3d(double t_s, const LidarSpan& span)>> boresight_rad;
  /// Angle by which the beams are turned toward +scan_axis beyond what is assumed.
  double scan_cone_rad = 0.0;
  /// What the scanner makes of a vector in its frame at the true time t_s.
  std::vector<std::function<Eigen::Vector3d(const Eigen::Vector3d& u_s, double t_s)>> laser_vector;
  std::vector<std::function<double(double t_s, const LidarSpan& span)>> lidar_tag_shift_s;

  /// sigma_p of a pair from the one before, m.
  std::vector<std::function<double(double sigma_p_m, double mean_range_m)>> pair_sigma_m;
  /// Errors of a finished pair.
  std::vector<std::function<void(LidarPair* pair)>> pairs;
  /// Errors of all pairs together, when those of each are done.
  std::vector<std::function<void(PairData* pairs)>> all_pairs;

  /// The attitude of trajectory.out is multiplied from the right by these.
  std::vector<Eigen::Quaterniond> trajectory_turn;
};

/// The effects of a scenario. Random numbers go by the seed, the effect's name and its index among
/// the entries of that name. Without `noise` the stochastic effects are left out.
ActiveEffects MakeActiveEffects(const Scenario& scenario, std::uint64_t seed, bool noise);

/// Adds the caller's errors to the lists, behind the effects. The functions refer to the truth.
void AddOwnErrors(const OwnErrors& own, const std::shared_ptr<const TruthTrajectory>& truth,
                  ActiveEffects* active);

/// Throws InvalidConfig about the shift that makes the tag at t_s not later than the one before.
[[noreturn]] void RefuseStepBack(const std::vector<TagShift>& shifts, double before_s, double t_s);

/// The tag of the true time t_s.
double Tag(const std::vector<TagShift>& shifts, double t_s);

/// True where one of the gaps is.
bool InGap(const std::vector<DataGap>& gaps, double t_s);

}  // namespace dn
