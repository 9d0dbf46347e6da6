#pragma once

#include <dn/eigen_alignment.h>
#include <dn/geo/named_columns.h>

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

/// Returns true if the interval of a sample begins where that of the sample before it ends.
inline bool Adjoin(const ImuSample& before, const ImuSample& after) {
  return after.t_s - after.dt_s - before.t_s < kImuTimeTolerance_s;
}

/// Formats of inertial files; see ReadImu.
enum class ImuFormat { kOdyn, kIncrements };

/// Meaning of the rates in a row of the file.
enum class ImuSampling {
  kMean,  ///< the rates are means over the interval that ends at the time tag
  /// Rates are point samples; the mean of an interval is that of its two ends (trapezoid).
  kInstantaneous,
};

/// Options for reading a file of inertial data.
struct ImuReadOptions {
  ImuFormat format = ImuFormat::kOdyn;
  /// Names of the columns (t, wx, wy, wz, fx, fy, fz); empty: the columns of the format.
  ColumnNames columns = {};
  ImuSampling sampling = ImuSampling::kMean;
  /// One unit of the rates of the file (rad/s), or of the angle increments (rad).
  double rate_unit_radps = 1.0;
  /// One unit of the forces of the file (m/s^2), or of the velocity increments (m/s).
  double force_unit_mps2 = 1.0;
  /// Rotation from the axes of the file to body (forward-right-down).
  Eigen::Matrix3d R_imu_to_body = Eigen::Matrix3d::Identity();
  /// Error of the time tags, tag = t + time_offset_s; subtracted first.
  double time_offset_s = 0.0;
  double t_begin_s = -1e300;  ///< rows outside [t_begin_s, t_end_s] are ignored
  double t_end_s = 1e300;
  /// A longer step between samples is a gap; a shorter hole is bridged. Absent: the limit of
  /// LongestImuBridge applies.
  std::optional<double> max_gap_s = std::nullopt;
};

/// Quantities of the columns of an inertial file: rates and forces, or increments.
const std::vector<std::string>& ImuQuantities();

/// Gap in the data: no sample covers (t_begin_s, t_end_s].
struct ImuGap {
  double t_begin_s = 0.0;
  double t_end_s = 0.0;
};

/// Hole that is too short to count as a gap. The hole is (t_begin_s, row.t_s - row.dt_s], and the
/// sample after it also covers it. The rates in the hole are taken as the mean of both neighbouring
/// samples. The errors are estimated by interpolating known samples nearby in the same way, up to
/// 64 on either side. The axis with the largest errors determines the sigma of all three.
struct ImuBridge {
  double t_begin_s = 0.0;
  ImuSample row;                 ///< the sample after the hole, over its own interval only
  double gyro_sigma_rad = 0.0;   ///< sigma of the angle over the hole, per axis
  double accel_sigma_mps = 0.0;  ///< sigma of the velocity over the hole, per axis
};

/// Inertial data of one sensor, sorted by time.
struct ImuData {
  std::vector<ImuSample> samples;
  /// Mean interval without those above 1.75 medians; for uneven data without gaps.
  double nominal_dt_s = 0.0;
  /// True if fewer than four of five steps lie within 25 % of the median step. In that case a long
  /// step is not a sign of a lost row. Every step up to max_gap_s is then the interval of its row.
  bool uneven = false;
  double max_jitter_s = 0.0;  ///< largest |dt - nominal_dt_s| outside gaps and bridges
  /// Steps longer than max_gap_s. The sample after a gap keeps dt_s = nominal_dt_s, so that the
  /// hole remains visible.
  std::vector<ImuGap> gaps;
  std::vector<ImuBridge> bridges;  ///< holes shorter than a gap, sorted
  long repeated_rows_dropped = 0;
  /// Rows whose six values equal those of the row before: the logger is faster than the sensor.
  long repeated_values = 0;
  long rows_outside_span = 0;

  double t_begin_s() const { return samples.front().t_s - samples.front().dt_s; }
  double t_end_s() const { return samples.back().t_s; }
};

/// Reads IMU.txt: t, w xyz [rad/s], f xyz [m/s^2], or increments t, dtheta [rad], dv [m/s]. Throws
/// InvalidInput with file:line for bad rows. Throws InvalidInput also for values in wrong units: a
/// mean |f| near 1 (g), an rms rate too large for rad/s (deg/s), and a usual interval above 1 s
/// (milliseconds).
ImuData ReadImu(const std::filesystem::path& file, const ImuReadOptions& options);

/// Classifies the steps between samples that are longer than 1.5 nominal_dt_s. A step up to
/// LongestImuBridge becomes a bridge (in uneven data it remains an interval); a longer step becomes
/// a gap. On entry every sample must cover its own interval only; a sample after a hole covers
/// nominal_dt_s. Fills gaps, bridges and max_jitter_s. Throws InvalidConfig if max_gap_s is shorter
/// than nominal_dt_s.
void CloseShortHoles(std::optional<double> max_gap_s, ImuData* imu);

/// Returns the longest step between samples that is neither a bridge nor a gap. It allows for the
/// rounding of time tags in seconds of week, 1e-10 s and more.
double LongestImuInterval(double nominal_dt_s);

/// Returns the longest step between samples that is not a gap: max_gap_s if given, else 5
/// nominal_dt_s and at least 50 ms. During so short a time the neighbouring rows represent the
/// motion of a surveying platform; the remaining error is measured (ImuBridge).
double LongestImuBridge(std::optional<double> max_gap_s, double nominal_dt_s);

/// Returns the index range [first, last) of the samples whose intervals overlap (t0_s, t1_s].
std::pair<std::size_t, std::size_t> SampleRange(const ImuData& imu, double t0_s, double t1_s);

/// Returns true if a gap of the data overlaps (t0_s, t1_s) by more than a microsecond.
bool HasGap(const ImuData& imu, double t0_s, double t1_s);

}  // namespace dn
