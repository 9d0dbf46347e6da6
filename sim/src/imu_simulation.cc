#include "imu_simulation.h"

#include <dn/sim/error_process.h>
#include <dn/sim/random.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "imu_effects.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr long kProgressSamples = 20000;

/// Mean rate and force between two states by Gauss-Lobatto quadrature with four points, two of them
/// at the ends: exact for polynomials of degree five, as Gauss-Legendre is with three.
void MeanBetween(const TruthTrajectory& truth, const TruthState& begin, const TruthState& end,
                 const ImuEffects& effects, ImuSample& sample) {
  static const double kNode = 1.0 / std::sqrt(5.0);
  const double middle_s = 0.5 * (begin.pose.t_s + end.pose.t_s);
  const double half_s = 0.5 * (end.pose.t_s - begin.pose.t_s);
  const TruthState early = truth.State(middle_s - kNode * half_s);
  const TruthState late = truth.State(middle_s + kNode * half_s);
  sample.w_ib_b_radps = (begin.w_ib_b + end.w_ib_b + 5.0 * (early.w_ib_b + late.w_ib_b)) / 12.0;
  const auto force = [&](const TruthState& state) {
    return effects.ActualForce(state, truth.frame());
  };
  sample.f_b_mps2 = (force(begin) + force(end) + 5.0 * (force(early) + force(late))) / 12.0;
}

/// White noise and bias processes of a triad.
class TriadErrors {
 public:
  // `extra` processes, beyond the assumed ones, have random numbers of their own.
  TriadErrors(const SensorNoise& noise, double white_ratio, const std::vector<BiasProcess>& extra,
              double dt_s, std::uint64_t seed, const std::string& name)
      : white_(white_ratio * noise.white / std::sqrt(dt_s)),
        random_(seed, name),
        extra_random_(seed, name + " extra") {
    Start(noise.processes, dt_s, random_, &processes_);
    Start(extra, dt_s, extra_random_, &extra_processes_);
  }

  Vector3d NextBias() {
    return NextSum(processes_, random_) + NextSum(extra_processes_, extra_random_);
  }
  Vector3d NextWhite() { return white_ * random_.Normal3(); }

 private:
  static void Start(const std::vector<BiasProcess>& models, double dt_s, Random& random,
                    std::vector<ErrorProcess>* processes) {
    for (const BiasProcess& model : models) {
      for (int axis = 0; axis < 3; ++axis) processes->emplace_back(model, dt_s, random);
    }
  }

  static Vector3d NextSum(std::vector<ErrorProcess>& processes, Random& random) {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t i = 0; i < processes.size(); ++i) {
      sum[static_cast<Eigen::Index>(i % 3)] += processes[i].NextMean(random);
    }
    return sum;
  }

  double white_;
  Random random_;
  Random extra_random_;
  std::vector<ErrorProcess> processes_;
  std::vector<ErrorProcess> extra_processes_;
};

/// Interval lengths as a reader finds them: differences of the tags.
void DescribeIntervals(ImuData& data, double nominal_dt_s) {
  data.nominal_dt_s = nominal_dt_s;
  data.samples.front().dt_s = nominal_dt_s;
  for (std::size_t i = 1; i < data.samples.size(); ++i) {
    ImuSample& sample = data.samples[i];
    sample.dt_s = sample.t_s - data.samples[i - 1].t_s;
    data.max_jitter_s = std::max(data.max_jitter_s, std::abs(sample.dt_s - nominal_dt_s));
  }
}

}  // namespace

SimulatedImu SimulateImu(const Scenario& scenario, const TruthTrajectory& truth,
                         const ImuSimulation& options) {
  const ImuScenario& imu = scenario.imu;
  ImuEffects effects(scenario, options.seed);
  const double dt_s = 1.0 / imu.rate_hz;
  const auto count = static_cast<long>((truth.t_end_s() - truth.t_begin_s()) * imu.rate_hz + 1e-6);
  TriadErrors gyro(imu.model.gyro, effects.gyro_noise_ratio(), effects.gyro_processes(), dt_s,
                   options.seed, "gyro");
  TriadErrors accel(imu.model.accel, effects.accel_noise_ratio(), effects.accel_processes(), dt_s,
                    options.seed, "accel");
  const auto tag_s = [&](long k) {
    return truth.t_begin_s() + static_cast<double>(k) / imu.rate_hz;
  };

  SimulatedImu out;
  out.data.samples.resize(static_cast<std::size_t>(count));
  out.gyro_bias_radps.assign(out.data.samples.size(), Vector3d::Zero());
  out.accel_bias_mps2.assign(out.data.samples.size(), Vector3d::Zero());
  out.reference.reserve(out.data.samples.size() + 1);
  TruthState begin = truth.State(tag_s(0));
  out.reference.push_back(ToNavPoint(begin, truth.frame()));
  for (long k = 1; k <= count; ++k) {
    const auto i = static_cast<std::size_t>(k - 1);
    ImuSample& sample = out.data.samples[i];
    sample.t_s = tag_s(k);
    const TruthState end = truth.State(sample.t_s);
    MeanBetween(truth, begin, end, effects, sample);
    out.reference.push_back(ToNavPoint(end, truth.frame()));
    begin = end;
    effects.Distort(&sample);
    if (options.noise) {
      out.gyro_bias_radps[i] = gyro.NextBias();
      out.accel_bias_mps2[i] = accel.NextBias();
      sample.w_ib_b_radps += out.gyro_bias_radps[i] + gyro.NextWhite();
      sample.f_b_mps2 += out.accel_bias_mps2[i] + accel.NextWhite();
      effects.Shake(&sample);
    }
    if (options.progress && k % kProgressSamples == 0) {
      options.progress(static_cast<double>(k) / static_cast<double>(count));
    }
  }
  DescribeIntervals(out.data, dt_s);
  ApplyImuTagEffects(scenario, &out);
  return out;
}

}  // namespace dn
