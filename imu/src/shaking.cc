#include <dn/geo/local_frame.h>
#include <dn/imu/shaking.h>
#include <dn/median.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

#include "spectrum.h"

namespace dn {
namespace {

constexpr double kLowest_hz = 5.0, kLowestRate_hz = 20.0;
// A line exceeds its neighbours within kNeighbours by kLineFactor.
constexpr int kNeighbours = 25;
constexpr double kLineFactor = 4.0, kLineEdge = 1.5;
constexpr std::size_t kMostLines = 6;
// Power relative to that of white noise up to which a record counts as calm.
constexpr double kCalmExcess = 0.1;
constexpr double kTwoPi = 2.0 * std::numbers::pi;

using Floors = std::array<double, ImuSpectrum::kAxes>;

class Survey {
 public:
  Survey(const ImuSpectrum& spectrum, std::size_t num_parts, double dt_s)
      : spectrum_(spectrum), dt_s_(dt_s) {
    first_ = static_cast<int>(std::ceil(kLowest_hz / spectrum.step_hz));
    past_ = static_cast<int>(spectrum.density[0].size());
    for (std::size_t axis = 0; axis < ImuSpectrum::kAxes; ++axis) {
      floor_[axis] =
          WhiteFloor(spectrum.density[axis], static_cast<std::size_t>(first_), num_parts);
    }
  }

  Shaking Run() {
    out_.low_hz = kLowest_hz;
    out_.high_hz = 0.5 / dt_s_;
    MeasureLevels();
    MeasureCost();
    FindLines();
    return out_;
  }

 private:
  double Frequency(int k) const { return k * spectrum_.step_hz; }
  /// Returns the power beyond the white noise in one step of frequency.
  double Excess(std::size_t axis, int k) const {
    return (spectrum_.density[axis][static_cast<std::size_t>(k)] - floor_[axis]) *
           spectrum_.step_hz;
  }
  /// Returns the sum over a range of frequencies of Excess times a weight; 0 if it is negative.
  template <class Weight>
  double Sum(std::size_t axis, int first, int past, const Weight& weight) const {
    double sum = 0.0;
    for (int k = first; k < past; ++k) sum += Excess(axis, k) * weight(k);
    return std::max(0.0, sum);
  }
  static double One(int) { return 1.0; }

  void MeasureLevels() {
    for (std::size_t axis = 0; axis < ImuSpectrum::kAxes; ++axis) {
      const double power = Sum(axis, first_, past_, &One);
      const auto k = static_cast<Eigen::Index>(axis % 3);
      (axis < 3 ? out_.rate_radps : out_.accel_mps2)[k] = std::sqrt(power);
      const double white = floor_[axis] * (past_ - first_) * spectrum_.step_hz;
      if (white > 0.0) out_.excess = std::max(out_.excess, power / white);
    }
  }

  /// Returns the fraction of the coning of a frequency that the samples do not resolve.
  double Unresolved(int k) const {
    const double x = kTwoPi * Frequency(k) * dt_s_;
    return std::abs(1.0 - std::sin(x) / x - (1.0 - std::cos(x)) * std::sin(x) / (3.0 * x));
  }

  /// Returns the largest drift that two axes cause together.
  double Drift(std::size_t a, std::size_t b) const {
    double sum = 0.0;
    for (int k = first_; k < past_; ++k) {
      const double product = std::max(0.0, Excess(a, k)) * std::max(0.0, Excess(b, k));
      sum += Unresolved(k) * std::sqrt(product) / (kTwoPi * Frequency(k));
    }
    return sum;
  }

  void MeasureCost() {
    const auto per_rate = [this](int order) {
      return [this, order](int k) { return std::pow(kTwoPi * Frequency(k), -2 * order); };
    };
    double coning2 = 0.0, sculling2 = 0.0;
    for (std::size_t a = 0; a < 3; ++a) {
      out_.turn_rad = std::max(out_.turn_rad, std::sqrt(Sum(a, first_, past_, per_rate(1))));
      out_.shift_m = std::max(out_.shift_m, std::sqrt(Sum(a + 3, first_, past_, per_rate(2))));
      for (std::size_t b = 0; b < 3; ++b) {
        if (b > a) coning2 += std::pow(Drift(a, b), 2);
        if (b != a) sculling2 += std::pow(Drift(a, b + 3), 2);
      }
    }
    out_.coning_radps = std::sqrt(coning2);
    out_.sculling_mps2 = std::sqrt(sculling2);
  }

  /// Returns the density of all axes in units of their white noise.
  std::vector<double> Joint() const {
    std::vector<double> joint(static_cast<std::size_t>(past_), 0.0);
    for (std::size_t axis = 0; axis < ImuSpectrum::kAxes; ++axis) {
      if (!(floor_[axis] > 0.0)) continue;
      for (std::size_t k = 0; k < joint.size(); ++k) {
        joint[k] += spectrum_.density[axis][k] / floor_[axis];
      }
    }
    return joint;
  }

  void FindLines() {
    const std::vector<double> joint = Joint();
    std::vector<double> around(joint.size(), 0.0);
    for (int k = first_; k < past_; ++k) {
      const int low = std::max(first_, k - kNeighbours), high = std::min(past_, k + kNeighbours);
      around[static_cast<std::size_t>(k)] =
          Median(std::vector<double>(joint.begin() + low, joint.begin() + high));
    }
    const auto exceeds = [&](int k, double factor) {
      const auto at = static_cast<std::size_t>(k);
      return k >= first_ && k < past_ && joint[at] > factor * around[at];
    };
    std::vector<std::pair<double, ShakingLine>> found;
    for (int k = first_; k < past_; ++k) {
      if (!exceeds(k, kLineFactor)) continue;
      int low = k, past = k + 1;
      while (exceeds(low - 1, kLineEdge)) --low;
      while (exceeds(past, kLineEdge)) ++past;
      found.push_back(Measure(joint, low, past));
      k = past;
    }
    std::sort(found.begin(), found.end(),
              [](const auto& a, const auto& b) { return a.first > b.first; });
    for (std::size_t k = 0; k < std::min(kMostLines, found.size()); ++k) {
      out_.lines.push_back(found[k].second);
    }
  }

  /// Returns the strength of a line, and its frequency and levels.
  std::pair<double, ShakingLine> Measure(const std::vector<double>& joint, int low,
                                         int past) const {
    double sum = 0.0, moment = 0.0;
    for (int k = low; k < past; ++k) {
      sum += joint[static_cast<std::size_t>(k)];
      moment += joint[static_cast<std::size_t>(k)] * Frequency(k);
    }
    ShakingLine line;
    line.frequency_hz = moment / sum;
    for (std::size_t axis = 0; axis < ImuSpectrum::kAxes; ++axis) {
      (axis < 3 ? line.rate_radps : line.accel_mps2)[static_cast<Eigen::Index>(axis % 3)] =
          std::sqrt(Sum(axis, low, past, &One));
    }
    return {sum, line};
  }

  const ImuSpectrum& spectrum_;
  double dt_s_;
  int first_ = 0, past_ = 0;
  Floors floor_{};
  Shaking out_;
};

}  // namespace

bool Shaking::calm() const { return lines.empty() && excess < kCalmExcess; }

std::optional<Shaking> FindShaking(const ImuData& imu) {
  if (imu.samples.empty() || imu.nominal_dt_s * kLowestRate_hz > 1.0) return std::nullopt;
  const std::vector<std::size_t> parts = SpectrumParts(imu);
  if (parts.empty()) return std::nullopt;
  return Survey(MeanSpectrum(imu, parts), parts.size(), imu.nominal_dt_s).Run();
}

/// Formats a value with two digits, without an exponent above 100.
std::string TwoDigits(double value) {
  char text[40];
  std::snprintf(text, sizeof(text), value < 99.5 ? "%.2g" : "%.0f", value);
  return text;
}

std::string Describe(const Shaking& shaking) {
  char text[200];
  std::snprintf(text, sizeof(text), "%s m/s^2 and %s deg/s rms from %.0f to %.0f Hz",
                TwoDigits(shaking.accel_mps2.maxCoeff()).c_str(),
                TwoDigits(kDegPerRad * shaking.rate_radps.maxCoeff()).c_str(), shaking.low_hz,
                shaking.high_hz);
  std::string all = text;
  for (std::size_t k = 0; k < shaking.lines.size(); ++k) {
    std::snprintf(text, sizeof(text), "%s%.1f", k == 0 ? ", lines at " : ", ",
                  shaking.lines[k].frequency_hz);
    all += text;
  }
  if (!shaking.lines.empty()) all += " Hz";
  std::snprintf(text, sizeof(text),
                "; it turns the sensor by %s mdeg and shifts it by %s mm rms; unresolved coning "
                "is at most %s deg/h, and sculling %s mg",
                TwoDigits(1e3 * kDegPerRad * shaking.turn_rad).c_str(),
                TwoDigits(1e3 * shaking.shift_m).c_str(),
                TwoDigits(3600.0 * kDegPerRad * shaking.coning_radps).c_str(),
                TwoDigits(shaking.sculling_mps2 / 9.80665e-3).c_str());
  return all + text;
}

}  // namespace dn
