#include "imu_simulation.h"

#include <dn/sim/error_process.h>
#include <dn/sim/random.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr long kProgressSamples = 20000;

/// Mean rate and force over an interval by Gauss-Legendre quadrature with three points: exact for
/// polynomials of degree five.
void MeanOver(const TruthTrajectory& truth, double t0_s, double t1_s, ImuSample& sample) {
  static const double kNode = std::sqrt(0.6);
  const std::array<double, 3> nodes{-kNode, 0.0, kNode};
  constexpr std::array<double, 3> kWeights{5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const double t_s = 0.5 * (t0_s + t1_s) + 0.5 * (t1_s - t0_s) * nodes[i];
    const TruthState state = truth.State(t_s);
    sample.w_ib_b_radps += kWeights[i] * state.w_ib_b;
    sample.f_b_mps2 += kWeights[i] * state.f_b;
  }
}

/// White noise and bias processes of a triad.
class TriadErrors {
 public:
  TriadErrors(const SensorNoise& noise, double dt_s, std::uint64_t seed, const std::string& name)
      : white_(noise.white / std::sqrt(dt_s)), random_(seed, name) {
    for (const BiasProcess& process : noise.processes) {
      for (int axis = 0; axis < 3; ++axis) processes_.emplace_back(process, dt_s, random_);
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

void DescribeIntervals(ImuData& data, double nominal_dt_s) {
  std::vector<double> dt_s;
  for (std::size_t i = 1; i < data.samples.size(); ++i) {
    data.samples[i].dt_s = data.samples[i].t_s - data.samples[i - 1].t_s;
    dt_s.push_back(data.samples[i].dt_s);
  }
  if (dt_s.empty()) dt_s.push_back(nominal_dt_s);
  const auto middle = dt_s.begin() + static_cast<std::ptrdiff_t>(dt_s.size() / 2);
  std::nth_element(dt_s.begin(), middle, dt_s.end());
  data.nominal_dt_s = *middle;
  data.samples.front().dt_s = data.nominal_dt_s;
  for (const ImuSample& sample : data.samples) {
    data.max_jitter_s = std::max(data.max_jitter_s, std::abs(sample.dt_s - data.nominal_dt_s));
  }
}

}  // namespace

SimulatedImu SimulateImu(const ImuScenario& imu, const TruthTrajectory& truth,
                         const ImuSimulation& options) {
  const double dt_s = 1.0 / imu.rate_hz;
  const auto count = static_cast<long>((truth.t_end_s() - truth.t_begin_s()) * imu.rate_hz + 1e-6);
  TriadErrors gyro(imu.model.gyro, dt_s, options.seed, "gyro");
  TriadErrors accel(imu.model.accel, dt_s, options.seed, "accel");
  const auto tag_s = [&](long k) {
    return truth.t_begin_s() + static_cast<double>(k) / imu.rate_hz;
  };

  SimulatedImu out;
  out.data.samples.resize(static_cast<std::size_t>(count));
  out.gyro_bias_radps.assign(out.data.samples.size(), Vector3d::Zero());
  out.accel_bias_mps2.assign(out.data.samples.size(), Vector3d::Zero());
  for (long k = 1; k <= count; ++k) {
    const auto i = static_cast<std::size_t>(k - 1);
    ImuSample& sample = out.data.samples[i];
    sample.t_s = tag_s(k);
    MeanOver(truth, tag_s(k - 1), sample.t_s, sample);
    sample.w_ib_b_radps += options.gyro_scale.cwiseProduct(sample.w_ib_b_radps);
    if (options.noise) {
      out.gyro_bias_radps[i] = gyro.NextBias();
      out.accel_bias_mps2[i] = accel.NextBias();
      sample.w_ib_b_radps += out.gyro_bias_radps[i] + gyro.NextWhite();
      sample.f_b_mps2 += out.accel_bias_mps2[i] + accel.NextWhite();
    }
    if (options.progress && k % kProgressSamples == 0) {
      options.progress(static_cast<double>(k) / static_cast<double>(count));
    }
  }
  DescribeIntervals(out.data, dt_s);
  return out;
}

}  // namespace dn
