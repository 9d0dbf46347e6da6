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

/// Rate and specific force of ideal sensors.
struct RateAndForce {
  Vector3d w_ib_b = Vector3d::Zero();
  Vector3d f_b = Vector3d::Zero();

  RateAndForce& operator+=(const RateAndForce& other) {
    w_ib_b += other.w_ib_b;
    f_b += other.f_b;
    return *this;
  }
};

/// Computes mean rate and force between two states by Gauss-Lobatto quadrature with four points,
/// two of them at the ends. It is exact for polynomials of degree five, like Gauss-Legendre
/// quadrature with three points. Vibration makes the interval consist of several equal parts.
class MeanBetween {
 public:
  MeanBetween(const TruthTrajectory& truth, const ActiveEffects& effects, double interval_s)
      : truth_(truth),
        effects_(effects),
        parts_(std::max(
            1, static_cast<int>(std::ceil(kPartsPerPeriod * interval_s * truth.vibration_hz())))) {}

  void operator()(const Place& from, const Place& to, ImuSample* sample) const {
    const double begin_s = from.state.pose.t_s, end_s = to.state.pose.t_s;
    const double part_s = (end_s - begin_s) / parts_;
    RateAndForce sum, before = Measured(from.state);
    for (int k = 0; k < parts_; ++k) {
      const bool is_last = k + 1 == parts_;
      const double from_s = begin_s + k * part_s, to_s = is_last ? end_s : from_s + part_s;
      const double middle_s = 0.5 * (from_s + to_s), half_s = 0.5 * (to_s - from_s);
      const auto at = [&](double t_s) {
        return Measured(truth_.StateBetween(from.earth, to.earth, t_s));
      };
      const RateAndForce early = at(middle_s - kNode * half_s),
                         late = at(middle_s + kNode * half_s);
      const RateAndForce after = is_last ? Measured(to.state) : at(to_s);
      sum += {(before.w_ib_b + after.w_ib_b + 5.0 * (early.w_ib_b + late.w_ib_b)) / 12.0,
              (before.f_b + after.f_b + 5.0 * (early.f_b + late.f_b)) / 12.0};
      before = after;
    }
    sample->w_ib_b_radps = sum.w_ib_b / parts_;
    sample->f_b_mps2 = sum.f_b / parts_;
  }

 private:
  static constexpr double kNode = 0.44721359549995794;  // 1 / sqrt(5)
  // Two parts per period of the fastest vibration: the relative error of the mean is below 1e-3.
  static constexpr double kPartsPerPeriod = 2.0;

  RateAndForce Measured(const TruthState& state) const {
    return {state.w_ib_b, ActualForce(state, truth_.frame(), effects_)};
  }

  const TruthTrajectory& truth_;
  const ActiveEffects& effects_;
  int parts_;
};

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
  const MeanBetween set_means(truth, effects, dt_s);
  Place begin(truth, tag_s(0));
  out.reference.push_back(ToNavPoint(begin.state, begin.earth));
  for (long k = 1; k <= count; ++k) {
    const auto i = static_cast<std::size_t>(k - 1);
    ImuSample& sample = out.data.samples[i];
    sample.t_s = tag_s(k);
    const Place end(truth, sample.t_s);
    set_means(begin, end, &sample);
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
