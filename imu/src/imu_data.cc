#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/imu/imu_data.h>
#include <dn/imu/imu_rows.h>
#include <dn/median.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

namespace dn {
namespace {

using Eigen::Vector3d;

/// Limits of the mean |f|. It is near 9.8 m/s^2 for any vehicle that does not fall, whatever its
/// motion.
constexpr double kLowestMeanForce = 3.0;
constexpr double kHighestMeanForce = 50.0;
constexpr double kLowestMeanForceInG = 0.2;
/// Limit of the rms rate over a whole file (115 deg/s). Surveying platforms do not rotate this
/// fast, and most flights in deg/s exceed the limit.
constexpr double kHighestRmsRate = 2.0;
/// Larger values cannot be rates [rad/s], forces [m/s^2] or increments of a sensor.
constexpr double kHighestValue = 1e6;
/// Inertial sensors are faster than this.
constexpr double kLongestUsualInterval_s = 1.0;

Vector3d ToBody(const Vector3d& v, double unit, const ImuReadOptions& options) {
  return options.R_imu_to_body.isIdentity(0.0) ? Vector3d(unit * v)
                                               : Vector3d(options.R_imu_to_body * (unit * v));
}

[[noreturn]] void FailSize(double value, const FileLocation& where) {
  throw InvalidInput("IMU data: " + FormatDouble(value) +
                         " is too large for an angular rate in rad/s or a specific force in m/s^2",
                     where);
}

std::vector<ImuRow> ReadRows(const std::filesystem::path& file, const ImuReadOptions& options,
                             long* repeated_rows_dropped) {
  std::vector<std::size_t> columns{7};
  if (options.format == ImuFormat::kIncrements) columns.push_back(8);  // an odometer, not used
  TextTable table = options.columns.empty()
                        ? ReadTextTable(file, columns)
                        : ReadNamedColumns(file, options.columns, ImuQuantities());
  std::vector<std::size_t> keep;
  *repeated_rows_dropped = ContinueAndCheckTimes(table, keep, options.time_offset_s);
  std::vector<ImuRow> rows;
  rows.reserve(keep.size());
  for (const std::size_t i : keep) {
    const double* x = table.row(i);
    for (int c = 1; c < 7; ++c) {
      const double value = x[c] * (c < 4 ? options.rate_unit_radps : options.force_unit_mps2);
      if (!(std::abs(value) <= kHighestValue)) FailSize(value, {file.string(), table.lines[i]});
    }
    rows.push_back({x[0], ToBody({x[1], x[2], x[3]}, options.rate_unit_radps, options),
                    ToBody({x[4], x[5], x[6]}, options.force_unit_mps2, options)});
  }
  if (rows.size() < 2) {
    throw InvalidInput("IMU data: " + std::to_string(rows.size()) +
                           " row, but at least 2 are needed to determine the interval",
                       {file.string(), table.lines.empty() ? 0 : table.lines.front()});
  }
  return rows;
}

/// Intervals of the sensor, estimated from the steps between the rows.
struct Intervals {
  double nominal_s;
  bool uneven;
  double longest_s;  ///< longest step between adjacent rows
};

/// Estimates the usual interval as the mean of the steps up to 1.75 medians, which have no lost
/// row. The median alone would differ from the mean if tags are rounded to a coarse clock.
Intervals FindIntervals(const std::vector<ImuRow>& rows, std::optional<double> max_gap_s) {
  constexpr double kEvenShare = 0.8, kNear = 0.25;
  std::vector<double> dt(rows.size() - 1);
  for (std::size_t i = 0; i < dt.size(); ++i) dt[i] = rows[i + 1].t_s - rows[i].t_s;
  const double median_s = Median(dt);
  const auto near = std::count_if(
      dt.begin(), dt.end(), [&](double x) { return std::abs(x - median_s) <= kNear * median_s; });
  const bool uneven = static_cast<double>(near) < kEvenShare * static_cast<double>(dt.size());
  const double longest_s = uneven ? LongestImuBridge(max_gap_s, median_s) : 1.75 * median_s;
  const auto end =
      std::partition(dt.begin(), dt.end(), [longest_s](double x) { return x <= longest_s; });
  const double nominal_s = end == dt.begin() ? median_s
                                             : std::accumulate(dt.begin(), end, 0.0) /
                                                   static_cast<double>(end - dt.begin());
  return {nominal_s, uneven,
          uneven ? LongestImuBridge(max_gap_s, nominal_s) : LongestImuInterval(nominal_s)};
}

void CheckInterval(double nominal_dt_s, const FileLocation& where) {
  if (nominal_dt_s <= kLongestUsualInterval_s) return;
  throw InvalidInput(
      "IMU data: the usual interval between the rows is " + FormatDouble(nominal_dt_s) +
          ", too long for seconds: is the time in milliseconds? Divide it by 1000 (by 1e6 if "
          "in microseconds)",
      where);
}

/// Returns the sample that ends at row i, over its own interval. This is the step from the row
/// before; at the first row (i = 0) and after a hole it is the usual interval.
ImuSample Sample(const std::vector<ImuRow>& rows, std::size_t i, const Intervals& intervals,
                 const ImuReadOptions& options) {
  const ImuRow& row = rows[i];
  const double since_last_s = i == 0 ? 0.0 : row.t_s - rows[i - 1].t_s;
  const bool adjoins = i > 0 && since_last_s <= intervals.longest_s;
  const double dt_s = adjoins ? since_last_s : intervals.nominal_s;
  if (options.format == ImuFormat::kIncrements) {
    return {row.t_s, dt_s, row.w_ib_b_radps / dt_s, row.f_b_mps2 / dt_s};
  }
  const bool joined =
      i > 0 && since_last_s <= LongestImuBridge(options.max_gap_s, intervals.nominal_s);
  if (options.sampling == ImuSampling::kInstantaneous && joined) {
    // Weight of row i - 1 at the middle of the interval.
    const double back = 0.5 * dt_s / since_last_s;
    return {row.t_s, dt_s, row.w_ib_b_radps + back * (rows[i - 1].w_ib_b_radps - row.w_ib_b_radps),
            row.f_b_mps2 + back * (rows[i - 1].f_b_mps2 - row.f_b_mps2)};
  }
  return {row.t_s, dt_s, row.w_ib_b_radps, row.f_b_mps2};
}

std::string Rounded(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

/// Throws InvalidInput if the values cannot be in rad/s and m/s^2 (or increments of them).
void CheckUnits(const ImuData& imu, const std::filesystem::path& file) {
  double sum_f = 0.0, sum_w2 = 0.0;
  for (const ImuSample& sample : imu.samples) {
    sum_f += sample.f_b_mps2.norm();
    sum_w2 += sample.w_ib_b_radps.squaredNorm();
  }
  const double count = static_cast<double>(imu.samples.size());
  const double mean_f = sum_f / count, rms_w = std::sqrt(sum_w2 / count);
  const FileLocation where{file.string()};
  const std::string force =
      "IMU data: the mean specific force is " + Rounded(mean_f) + ", but 9.8 m/s^2 is expected: ";
  if (mean_f < kLowestMeanForceInG) {
    throw InvalidInput(
        force + "is gravity removed, or are these increments ('format: increments')?", where);
  }
  if (mean_f < kLowestMeanForce) {
    throw InvalidInput(force + "is it in g? Multiply by 9.80665, or set imu.force_unit: g", where);
  }
  if (mean_f > kHighestMeanForce) {
    throw InvalidInput(
        force + "is it in mg or counts, or are these rates read as increments ('format: odyn')?",
        where);
  }
  if (rms_w > kHighestRmsRate) {
    throw InvalidInput("IMU data: the angular rate is " + Rounded(rms_w) +
                           " rms, too large for rad/s: is it in deg/s? Multiply by "
                           "0.0174533, or set imu.rate_unit: deg/s",
                       where);
  }
}

}  // namespace

const std::vector<std::string>& ImuQuantities() {
  static const std::vector<std::string> quantities{"wx", "wy", "wz", "fx", "fy", "fz"};
  return quantities;
}

ImuData MakeImuData(const std::vector<ImuRow>& rows, const ImuReadOptions& options,
                    const std::filesystem::path& file) {
  assert(rows.size() >= 2);
  ImuData imu;
  const Intervals intervals = FindIntervals(rows, options.max_gap_s);
  imu.nominal_dt_s = intervals.nominal_s;
  imu.uneven = intervals.uneven;
  CheckInterval(imu.nominal_dt_s, {file.string()});
  // A point sample gives no mean before its own time: the first row only begins the first interval.
  const bool first_is_a_sample =
      options.format == ImuFormat::kIncrements || options.sampling == ImuSampling::kMean;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].t_s < options.t_begin_s || rows[i].t_s > options.t_end_s) {
      ++imu.rows_outside_span;
    } else if (i > 0 || first_is_a_sample) {
      imu.samples.push_back(Sample(rows, i, intervals, options));
      if (i > 0 && rows[i].w_ib_b_radps == rows[i - 1].w_ib_b_radps &&
          rows[i].f_b_mps2 == rows[i - 1].f_b_mps2)
        ++imu.repeated_values;
    }
  }
  if (imu.samples.empty()) {
    throw InvalidInput("IMU data: no row between " + FormatDouble(options.t_begin_s) + " and " +
                           FormatDouble(options.t_end_s) + " s; the file covers " +
                           FormatDouble(rows.front().t_s) + " to " + FormatDouble(rows.back().t_s) +
                           " s",
                       {file.string()});
  }
  CloseShortHoles(options.max_gap_s, &imu);
  CheckUnits(imu, file);
  return imu;
}

ImuData ReadImu(const std::filesystem::path& file, const ImuReadOptions& options) {
  long repeated_rows_dropped = 0;
  const std::vector<ImuRow> rows = ReadRows(file, options, &repeated_rows_dropped);
  ImuData imu = MakeImuData(rows, options, file);
  imu.repeated_rows_dropped = repeated_rows_dropped;
  return imu;
}

std::pair<std::size_t, std::size_t> SampleRange(const ImuData& imu, double t0_s, double t1_s) {
  const auto begin = imu.samples.begin(), end = imu.samples.end();
  const auto first = std::upper_bound(
      begin, end, t0_s, [](double t, const ImuSample& sample) { return t < sample.t_s; });
  const auto last = std::lower_bound(first, end, t1_s, [](const ImuSample& sample, double t) {
    return sample.t_s - sample.dt_s < t;
  });
  return {static_cast<std::size_t>(first - begin), static_cast<std::size_t>(last - begin)};
}

bool HasGap(const ImuData& imu, double t0_s, double t1_s) {
  constexpr double kSameTimeS = 1e-6;
  return std::any_of(imu.gaps.begin(), imu.gaps.end(), [&](const ImuGap& gap) {
    return gap.t_begin_s < t1_s - kSameTimeS && t0_s < gap.t_end_s - kSameTimeS;
  });
}

}  // namespace dn
