#include "imu_simulation.h"

#include <dn/error.h>
#include <dn/sim/error_process.h>
#include <dn/sim/random.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "imu_tags.h"
#include "sensor_sampling.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr long kProgressSamples = 20000;

/// Simulates white noise and assumed bias processes of a triad.
class TriadErrors {
 public:
  TriadErrors(const SensorNoise& noise, double white_ratio, double dt_s, std::uint64_t seed,
              const std::string& name)
      : white_(white_ratio * noise.white / std::sqrt(dt_s)), random_(seed, name) {
    for (const BiasProcess& model : noise.processes) {
      for (int axis = 0; axis < 3; ++axis) processes_.emplace_back(model, dt_s, random_);
    }
  }

  Vector3d NextBias() {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = 0; i < processes_.size(); ++i) {
      sum[static_cast<Eigen::Index>(i % 3)] += processes_[i].NextMean(random_);
    }
    return sum;
  }
  Vector3d NextWhite() { return white_ * random_.Normal3(); }

 private:
  double white_;
  Random random_;
  std::vector<ErrorProcess> processes_;
};

Vector3d Sum(const std::vector<std::function<Vector3d()>>& biases) {
  Vector3d sum = Vector3d::Zero();
  for (const auto& next : biases) sum += next();
  return sum;
}

/// Sets the interval lengths to the differences of the time tags, as a reader of the file does.
void DescribeIntervals(ImuData& data, double nominal_dt_s) {
  data.nominal_dt_s = nominal_dt_s;
  data.samples.front().dt_s = nominal_dt_s;
  for (std::size_t i = 1; i < data.samples.size(); ++i) {
    ImuSample& sample = data.samples[i];
    sample.dt_s = sample.t_s - data.samples[i - 1].t_s;
    data.max_jitter_s = std::max(data.max_jitter_s, std::abs(sample.dt_s - nominal_dt_s));
  }
}

/// Replaces the samples, which are values at their times, by what a reader makes of such rows.
void TakeAsPointSamples(SimulatedImu* imu) {
  imu->rows = ImuRows(imu->data);
  if (imu->rows.size() < 2) throw InvalidConfig("imu: too few inertial samples remain");
  imu->data = MakeImuData(imu->rows, {.sampling = ImuSampling::kInstantaneous}, "IMU.txt");
  for (auto* biases : {&imu->gyro_bias_radps, &imu->accel_bias_mps2}) {
    for (std::size_t k = 1; k < biases->size(); ++k) {
      (*biases)[k - 1] = 0.5 * ((*biases)[k - 1] + (*biases)[k]);
    }
    biases->resize(imu->data.samples.size());
  }
}

}  // namespace

std::vector<ImuRow> ImuRows(const ImuData& imu) {
  std::vector<ImuRow> rows;
  rows.reserve(imu.samples.size());
  auto bridge = imu.bridges.begin();
  for (const ImuSample& sample : imu.samples) {
    const bool bridges = bridge != imu.bridges.end() && bridge->row.t_s == sample.t_s;
    const ImuSample& row = bridges ? (bridge++)->row : sample;
    rows.push_back({row.t_s, row.w_ib_b_radps, row.f_b_mps2});
  }
  return rows;
}

SimulatedImu SimulateImu(const Scenario& scenario, const TruthTrajectory& truth,
                         const ImuSimulation& options, const ActiveEffects& effects) {
  const ImuScenario& imu = scenario.imu;
  const double dt_s = 1.0 / imu.rate_hz;
  const auto count = static_cast<long>((truth.t_end_s() - truth.t_begin_s()) * imu.rate_hz + 1e-6);
  TriadErrors gyro(imu.model.gyro, effects.gyro_noise_ratio, dt_s, options.seed, "gyro");
  TriadErrors accel(imu.model.accel, effects.accel_noise_ratio, dt_s, options.seed, "accel");
  const auto tag_s = [&](long k) {
    return truth.t_begin_s() + static_cast<double>(k) / imu.rate_hz;
  };

  SimulatedImu out;
  out.data.samples.resize(static_cast<std::size_t>(count));
  out.gyro_bias_radps.assign(out.data.samples.size(), Vector3d::Zero());
  out.accel_bias_mps2.assign(out.data.samples.size(), Vector3d::Zero());
  out.reference.reserve(out.data.samples.size() + 1);
  SensorSampling set_values(imu, truth, effects);
  Place begin(truth, tag_s(0));
  out.reference.push_back(ToNavPoint(begin.state, begin.earth));
  for (long k = 1; k <= count; ++k) {
    const auto i = static_cast<std::size_t>(k - 1);
    ImuSample& sample = out.data.samples[i];
    sample.t_s = tag_s(k);
    const Place end(truth, sample.t_s);
    set_values(begin, end, &sample);
    out.reference.push_back(ToNavPoint(end.state, end.earth));
    begin = end;
    const ImuSample exact = sample;
    for (const auto& distort : effects.triads) distort(exact, &sample);
    if (options.noise) {
      out.gyro_bias_radps[i] = gyro.NextBias() + Sum(effects.gyro_bias);
      out.accel_bias_mps2[i] = accel.NextBias() + Sum(effects.accel_bias);
      sample.w_ib_b_radps += out.gyro_bias_radps[i] + gyro.NextWhite();
      sample.f_b_mps2 += out.accel_bias_mps2[i] + accel.NextWhite();
      for (const auto& add_noise : effects.imu_noise) add_noise(&sample);
    }
    if (options.progress && k % kProgressSamples == 0) {
      options.progress(static_cast<double>(k) / static_cast<double>(count));
    }
  }
  DescribeIntervals(out.data, dt_s);
  ApplyImuTagEffects(effects, &out);
  if (imu.sampling == ImuSampling::kInstantaneous) TakeAsPointSamples(&out);
  return out;
}

}  // namespace dn
