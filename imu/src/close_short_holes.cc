#include <dn/error.h>
#include <dn/geo/text_table.h>
#include <dn/imu/imu_data.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr double kGapIntervals = 5.0;
constexpr double kShortestGap_s = 0.05;
constexpr double kTagTolerance_s = 1e-6;
/// Number of known samples on either side that are interpolated to estimate the error of a bridge.
constexpr std::size_t kTrials = 64;

/// Sums of squared interpolation errors, per axis.
struct Errors {
  Vector3d w = Vector3d::Zero(), f = Vector3d::Zero();
  double count = 0.0;
};

/// Adds the error of interpolating the mean of samples [first + 1, last) from its two neighbours.
void AddError(const std::vector<ImuSample>& x, std::size_t first, std::size_t last, Errors* sum) {
  Vector3d w = Vector3d::Zero(), f = Vector3d::Zero();
  for (std::size_t k = first + 1; k < last; ++k) {
    w += x[k].w_ib_b_radps;
    f += x[k].f_b_mps2;
  }
  const double inside = static_cast<double>(last - first - 1);
  w = w / inside - 0.5 * (x[first].w_ib_b_radps + x[last].w_ib_b_radps);
  f = f / inside - 0.5 * (x[first].f_b_mps2 + x[last].f_b_mps2);
  sum->w += w.cwiseAbs2();
  sum->f += f.cwiseAbs2();
  sum->count += 1.0;
}

/// Returns true if no hole, bridged or not, lies between sample k and the one before.
bool FollowsWithoutHole(const ImuData& imu, std::size_t k) {
  const ImuSample& sample = imu.samples[k];
  return sample.t_s - imu.samples[k - 1].t_s <= LongestImuInterval(imu.nominal_dt_s) &&
         sample.dt_s <= LongestImuInterval(imu.nominal_dt_s);
}

/// Returns the interpolation errors of holes of `missing` samples near the hole that ends before
/// sample k.
Errors NearbyErrors(const ImuData& imu, std::size_t k, std::size_t missing) {
  const std::size_t reach = kTrials + missing;
  std::size_t begin = k - 1;
  while (begin > 0 && k - 1 - begin < reach && FollowsWithoutHole(imu, begin)) --begin;
  std::size_t end = k + 1;
  while (end < imu.samples.size() && end - k <= reach && FollowsWithoutHole(imu, end)) ++end;
  Errors sum;
  for (std::size_t i = begin; i + missing + 1 < k; ++i) {
    AddError(imu.samples, i, i + missing + 1, &sum);
  }
  for (std::size_t i = k; i + missing + 1 < end; ++i) {
    AddError(imu.samples, i, i + missing + 1, &sum);
  }
  return sum;
}

/// Extends sample k over the hole before it and adds a bridge.
void Bridge(std::size_t k, ImuData* imu) {
  ImuSample& sample = imu->samples[k];
  ImuBridge bridge{imu->samples[k - 1].t_s, sample};
  const bool after_bridge =
      !imu->bridges.empty() && imu->bridges.back().row.t_s == bridge.t_begin_s;
  const ImuSample& before = after_bridge ? imu->bridges.back().row : imu->samples[k - 1];
  const double hole_s = sample.t_s - sample.dt_s - bridge.t_begin_s;
  const double missing = std::max(1.0, std::round(hole_s / imu->nominal_dt_s));
  Errors errors = NearbyErrors(*imu, k, static_cast<std::size_t>(missing));
  if (errors.count == 0.0) {
    errors.w = 0.25 * (sample.w_ib_b_radps - before.w_ib_b_radps).cwiseAbs2();
    errors.f = 0.25 * (sample.f_b_mps2 - before.f_b_mps2).cwiseAbs2();
    errors.count = 1.0;
  }
  bridge.gyro_sigma_rad = hole_s * std::sqrt(errors.w.maxCoeff() / errors.count);
  bridge.accel_sigma_mps = hole_s * std::sqrt(errors.f.maxCoeff() / errors.count);

  // Weight of the sample before the hole.
  const double share = 0.5 * hole_s / (hole_s + sample.dt_s);
  sample.w_ib_b_radps += share * (before.w_ib_b_radps - sample.w_ib_b_radps);
  sample.f_b_mps2 += share * (before.f_b_mps2 - sample.f_b_mps2);
  sample.dt_s = sample.t_s - bridge.t_begin_s;
  imu->bridges.push_back(bridge);
}

}  // namespace

double LongestImuInterval(double nominal_dt_s) { return 1.5 * nominal_dt_s + kTagTolerance_s; }

double LongestImuBridge(std::optional<double> max_gap_s, double nominal_dt_s) {
  return max_gap_s.value_or(std::max(kGapIntervals * nominal_dt_s, kShortestGap_s)) +
         kTagTolerance_s;
}

void CloseShortHoles(std::optional<double> max_gap_s, ImuData* imu) {
  const double longest_bridge_s = LongestImuBridge(max_gap_s, imu->nominal_dt_s);
  if (longest_bridge_s < imu->nominal_dt_s) {
    throw InvalidConfig("imu.max_gap_s is " + FormatDouble(*max_gap_s) +
                        " s, shorter than the usual interval of the IMU data, " +
                        FormatDouble(imu->nominal_dt_s) + " s: every step would be a gap");
  }
  const double longest_s = imu->uneven
                               ? longest_bridge_s
                               : std::min(LongestImuInterval(imu->nominal_dt_s), longest_bridge_s);
  imu->gaps.clear();
  imu->bridges.clear();
  imu->max_jitter_s = 0.0;
  for (std::size_t k = 1; k < imu->samples.size(); ++k) {
    ImuSample& sample = imu->samples[k];
    const double before_s = imu->samples[k - 1].t_s;
    const double step_s = sample.t_s - before_s;
    if (step_s <= longest_s) {
      imu->max_jitter_s = std::max(imu->max_jitter_s, std::abs(step_s - imu->nominal_dt_s));
    } else if (step_s <= longest_bridge_s) {
      Bridge(k, imu);
    } else {
      sample.dt_s = imu->nominal_dt_s;
      imu->gaps.push_back({before_s, sample.t_s - sample.dt_s});
    }
  }
}

}  // namespace dn
