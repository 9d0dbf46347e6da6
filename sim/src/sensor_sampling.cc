#include "sensor_sampling.h"

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

using Eigen::Vector3d;

// Node of the Gauss-Lobatto quadrature with four points, 1 / sqrt(5).
constexpr double kNode = 0.44721359549995794;
// Two parts per period of the fastest vibration: the relative error of the mean is below 1e-3.
constexpr double kPartsPerPeriod = 2.0;
// Samples of the filter's input per period of the fastest vibration, and of the cut-off frequency.
constexpr double kSamplesPerPeriod = 4.0, kSamplesPerCutOff = 16.0;

/// Returns the specific force with the actual gravity instead of the normal one.
Vector3d ActualForce(const TruthState& state, const LocalFrame& frame,
                     const ActiveEffects& effects) {
  Vector3d f_b = state.f_b;
  for (const auto& gravity_m : effects.gravity_m) {
    f_b -= state.pose.q_mb.conjugate() * gravity_m(state.pose.p_mb, frame);
  }
  return f_b;
}

int Parts(const ImuScenario& imu, double vibration_hz) {
  double rate_hz = kPartsPerPeriod * vibration_hz;
  if (imu.filter_hz) {
    rate_hz = std::max(kSamplesPerPeriod * vibration_hz, kSamplesPerCutOff * *imu.filter_hz);
  }
  return std::max(1, static_cast<int>(std::ceil(rate_hz / imu.rate_hz)));
}

}  // namespace

SensorSampling::SensorSampling(const ImuScenario& imu, const TruthTrajectory& truth,
                               const ActiveEffects& effects)
    : imu_(imu), truth_(truth), effects_(effects), parts_(Parts(imu, truth.vibration_hz())) {
  if (imu.filter_hz) delay_s_ = LowPass::Delay(*imu.filter_hz, parts_ * imu.rate_hz);
}

void SensorSampling::operator()(const Place& from, const Place& to, ImuSample* sample) {
  Vector value;
  if (imu_.filter_hz) {
    value = Filtered(from, to);
  } else if (imu_.sampling == ImuSampling::kMean) {
    value = MeanBetween(from, to);
  } else {
    value = Measured(to.state);
  }
  sample->w_ib_b_radps = value.head<3>();
  sample->f_b_mps2 = value.tail<3>();
}

SensorSampling::Vector SensorSampling::Measured(const TruthState& state) const {
  Vector value;
  value << state.w_ib_b, ActualForce(state, truth_.frame(), effects_);
  return value;
}

/// Computes mean rate and force between two states by Gauss-Lobatto quadrature with four points,
/// two of them at the ends. It is exact for polynomials of degree five, like Gauss-Legendre
/// quadrature with three points. Vibration makes the interval consist of several equal parts.
SensorSampling::Vector SensorSampling::MeanBetween(const Place& from, const Place& to) const {
  const double begin_s = from.state.pose.t_s, end_s = to.state.pose.t_s;
  const double part_s = (end_s - begin_s) / parts_;
  Vector sum = Vector::Zero(), before = Measured(from.state);
  for (int k = 0; k < parts_; ++k) {
    const bool is_last = k + 1 == parts_;
    const double from_s = begin_s + k * part_s, to_s = is_last ? end_s : from_s + part_s;
    const double middle_s = 0.5 * (from_s + to_s), half_s = 0.5 * (to_s - from_s);
    const auto at = [&](double t_s) {
      return Measured(truth_.StateBetween(from.earth, to.earth, t_s));
    };
    const Vector early = at(middle_s - kNode * half_s), late = at(middle_s + kNode * half_s);
    const Vector after = is_last ? Measured(to.state) : at(to_s);
    sum += (before + after + 5.0 * (early + late)) / 12.0;
    before = after;
  }
  return sum / parts_;
}

SensorSampling::Vector SensorSampling::NextFiltered(const Place& from, const Place& to,
                                                    double t_s) {
  const double input_s = std::min(t_s + delay_s_, truth_.t_end_s());
  const Vector input = Measured(truth_.StateBetween(from.earth, to.earth, input_s));
  if (!filter_) filter_.emplace(*imu_.filter_hz, parts_ * imu_.rate_hz, input);
  return filter_->Next(input);
}

/// The mean is that of the trapezoids between the samples of the filter.
SensorSampling::Vector SensorSampling::Filtered(const Place& from, const Place& to) {
  const double begin_s = from.state.pose.t_s, end_s = to.state.pose.t_s;
  if (!filter_) last_filtered_ = NextFiltered(from, to, begin_s);
  Vector sum = Vector::Zero();
  for (int k = 1; k <= parts_; ++k) {
    const Vector next = NextFiltered(from, to, begin_s + (end_s - begin_s) * k / parts_);
    sum += 0.5 * (last_filtered_ + next);
    last_filtered_ = next;
  }
  return imu_.sampling == ImuSampling::kMean ? Vector(sum / parts_) : last_filtered_;
}

}  // namespace dn
