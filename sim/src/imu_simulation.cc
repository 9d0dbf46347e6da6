#include "imu_simulation.h"

#include <dn/sim/error_process.h>
#include <dn/sim/random.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "imu_tags.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr long kProgressSamples = 20000;

/// Returns the specific force with the actual gravity instead of the normal one.
Vector3d ActualForce(const TruthState& state, const LocalFrame& frame,
                     const ActiveEffects& effects) {
  Vector3d f_b = state.f_b;
  for (const auto& gravity_m : effects.gravity_m) {
    f_b -= state.pose.q_mb.conjugate() * gravity_m(state.pose.p_mb, frame);
  }
  return f_b;
}

/// State, with the Earth at its position.
struct Place {
  Place(const TruthTrajectory& truth, double t_s) : state(truth.State(t_s, &earth)) {}

  NormalEarth earth;
  TruthState state;
};

/// Computes mean rate and force between two states by Gauss-Lobatto quadrature with four points,
/// two of them at the ends. It is exact for polynomials of degree five, like Gauss-Legendre
/// quadrature with three points.
void MeanBetween(const TruthTrajectory& truth, const Place& from, const Place& to,
                 const ActiveEffects& effects, ImuSample& sample) {
  static const double kNode = 1.0 / std::sqrt(5.0);
  const TruthState &begin = from.state, &end = to.state;
  const double middle_s = 0.5 * (begin.pose.t_s + end.pose.t_s);
  const double half_s = 0.5 * (end.pose.t_s - begin.pose.t_s);
  const TruthState early = truth.StateBetween(from.earth, to.earth, middle_s - kNode * half_s);
  const TruthState late = truth.StateBetween(from.earth, to.earth, middle_s + kNode * half_s);
  sample.w_ib_b_radps = (begin.w_ib_b + end.w_ib_b + 5.0 * (early.w_ib_b + late.w_ib_b)) / 12.0;
  const auto force = [&](const TruthState& state) {
    return ActualForce(state, truth.frame(), effects);
  };
  sample.f_b_mps2 = (force(begin) + force(end) + 5.0 * (force(early) + force(late))) / 12.0;
}

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

}  // namespace

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
  Place begin(truth, tag_s(0));
  out.reference.push_back(ToNavPoint(begin.state, begin.earth));
  for (long k = 1; k <= count; ++k) {
    const auto i = static_cast<std::size_t>(k - 1);
    ImuSample& sample = out.data.samples[i];
    sample.t_s = tag_s(k);
    const Place end(truth, sample.t_s);
    MeanBetween(truth, begin, end, effects, sample);
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
  return out;
}

}  // namespace dn
