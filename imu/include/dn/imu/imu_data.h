#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace dn {

/// One inertial sample: means over the interval (t_s - dt_s, t_s], in body (forward-right-down).
struct ImuSample {
  double t_s = 0.0;   ///< end of the interval, GPS seconds of week
  double dt_s = 0.0;  ///< length of the interval
  Eigen::Vector3d w_ib_b_radps = Eigen::Vector3d::Zero();  ///< mean angular rate
  Eigen::Vector3d f_b_mps2 = Eigen::Vector3d::Zero();      ///< mean specific force
};

/// Two time tags closer than this are the same epoch (seconds of week resolve 1e-10 s).
inline constexpr double kImuTimeTolerance_s = 1e-7;

/// Whether the interval of a sample begins where that of the sample before it ends.
inline bool Adjoin(const ImuSample& before, const ImuSample& after) {
  return after.t_s - after.dt_s - before.t_s < kImuTimeTolerance_s;
}

/// Formats of inertial files; see ReadImu.
enum class ImuFormat { kOdyn, kIncrements };

/// What a row of rates stands for.
enum class ImuSampling {
  kMean,           ///< the file's rates are means over the interval that ends at the time tag
  kInstantaneous,  ///< point samples: the mean of an interval is taken from its two ends
                   ///< (trapezoid)
};

/// How a file of inertial data is read.
struct ImuReadOptions {
  ImuFormat format = ImuFormat::kOdyn;
  ImuSampling sampling = ImuSampling::kMean;
  double rate_unit_radps =
      1.0;  ///< one unit of the file's rates (or angle increments), rad/s (rad)
  double force_unit_mps2 = 1.0;  ///< one unit of its forces (or velocity increments), m/s^2 (m/s)
  /// Axes of the file's data -> body (forward-right-down).
  Eigen::Matrix3d R_imu_to_body = Eigen::Matrix3d::Identity();
  double time_offset_s = 0.0;  ///< of the file's tags, tag = t + value; removed on reading
  double t_begin_s = -1e300;   ///< rows outside [t_begin, t_end] are left out
  double t_end_s = 1e300;
  /// A longer step between samples is a gap, a shorter hole is bridged; absent: LongestImuBridge's.
  std::optional<double> max_gap_s = std::nullopt;
};

/// A hole in the data: no sample covers (t_begin_s, t_end_s].
struct ImuGap {
  double t_begin_s = 0.0;
  double t_end_s = 0.0;
};

/// A hole too short to be a gap. The sample after it stands for the hole, too: over (t_begin_s,
/// row.t_s - row.dt_s] the rates are assumed to be the mean of those of the neighbouring samples,
/// with the errors that the same interpolation makes of known samples nearby (up to 64 on either
/// side; the axis with the largest errors counts for all three).
struct ImuBridge {
  double t_begin_s = 0.0;
  ImuSample row;                 ///< the sample after the hole, over its own interval alone
  double gyro_sigma_rad = 0.0;   ///< of the angle over the hole, per axis
  double accel_sigma_mps = 0.0;  ///< of the velocity over the hole, per axis
};

/// Inertial data of one sensor, sorted by time.
struct ImuData {
  std::vector<ImuSample> samples;
  /// Mean interval, without those above 1.75 medians; of uneven data without gaps.
  double nominal_dt_s = 0.0;
  /// Fewer than four steps of five lie within a quarter of the median one: none is a sign of a lost
  /// row, and every one up to max_gap_s is the interval of its row.
  bool uneven = false;
  double max_jitter_s = 0.0;       ///< largest |dt - nominal| outside gaps and bridges
  std::vector<ImuGap> gaps;        ///< steps longer than max_gap_s; the sample after a gap keeps
                                   ///< dt_s = nominal_dt_s, so the hole stays visible
  std::vector<ImuBridge> bridges;  ///< shorter holes, sorted
  long repeated_rows_dropped = 0;
  long repeated_values = 0;  ///< rows with all six values of the row before: a logger faster than
                             ///< its sensor
  long rows_outside_span = 0;

  double t_begin_s() const { return samples.front().t_s - samples.front().dt_s; }
  double t_end_s() const { return samples.back().t_s; }
};

/// Reads IMU.txt: t, w xyz [rad/s], f xyz [m/s^2]; or increments t, dtheta [rad], dv [m/s]. Throws
/// InvalidInput naming file:line for bad rows, and for values that cannot be in these units (mean
/// |f| near 1: specific force in g; rates whose rms cannot be rad/s: deg/s; a usual interval above 1
/// s: milliseconds).
ImuData ReadImu(const std::filesystem::path& file, const ImuReadOptions& options);

/// Finds the steps between samples that are longer than 1.5 nominal_dt_s: one of up to
/// LongestImuBridge becomes a bridge (of uneven data it stays an interval), a longer one a gap. On entry every sample covers its
/// own interval alone, that after a hole nominal_dt_s. Fills gaps, bridges and max_jitter_s. Throws
/// InvalidConfig when max_gap_s is shorter than nominal_dt_s.
void CloseShortHoles(std::optional<double> max_gap_s, ImuData* imu);

/// Longest step between samples that is neither bridged nor a gap; time tags of week seconds are
/// rounded by 1e-10 s and more.
double LongestImuInterval(double nominal_dt_s);

/// Longest step between samples that is no gap: max_gap_s; absent: 5 nominal_dt_s, and at least
/// 50 ms. In less no surveying platform does what its neighbouring rows do not show, and how much it
/// does is measured (ImuBridge).
double LongestImuBridge(std::optional<double> max_gap_s, double nominal_dt_s);

/// Indices [first, last) of the samples whose intervals overlap (t0_s, t1_s].
std::pair<std::size_t, std::size_t> SampleRange(const ImuData& imu, double t0_s, double t1_s);

/// Whether a gap of the data overlaps (t0_s, t1_s) by more than a microsecond.
bool HasGap(const ImuData& imu, double t0_s, double t1_s);

}  // namespace dn
