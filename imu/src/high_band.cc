#include <dn/error.h>
#include <dn/imu/high_band.h>
#include <dn/median.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

namespace dn {
namespace {

using Taps = std::vector<double>;

constexpr std::size_t kTaps = 12;
constexpr double kMostWindows = 50000.0;
constexpr double kMostRepeated = 0.05;
constexpr double kCoarsestResolution = 2.0;  ///< in standard deviations of the noise

/// Returns the scaling filter of Daubechies, N = 6.
const Taps& ScalingFilter() {
  static const Taps filter{0.1115407433501095, 0.4946238903984533,  0.7511339080210959,
                           0.3152503517091982, -0.2262646939654400, -0.1297668675672625,
                           0.0975016055873225, 0.0275228655303053,  -0.0315820393174862,
                           0.0005538422011614, 0.0047772575109455,  -0.0010773010853085};
  return filter;
}

const Taps& WaveletFilter() {
  static const Taps filter = [] {
    Taps mirrored(ScalingFilter().rbegin(), ScalingFilter().rend());
    for (std::size_t k = 1; k < kTaps; k += 2) mirrored[k] = -mirrored[k];
    return mirrored;
  }();
  return filter;
}

/// Returns sum_l filter[l] x[2 k + l] for every k for which all terms exist.
std::vector<double> Halved(const std::vector<double>& x, const Taps& filter) {
  std::vector<double> out;
  for (std::size_t k = 0; k + kTaps <= x.size(); k += 2) {
    double sum = 0.0;
    for (std::size_t l = 0; l < kTaps; ++l) sum += filter[l] * x[k + l];
    out.push_back(sum);
  }
  return out;
}

Taps Convolved(const Taps& a, const Taps& b, std::size_t step_of_b) {
  Taps product(a.size() + step_of_b * (b.size() - 1), 0.0);
  for (std::size_t i = 0; i < a.size(); ++i) {
    for (std::size_t k = 0; k < b.size(); ++k) product[i + step_of_b * k] += a[i] * b[k];
  }
  return product;
}

/// Effect of an octave filter on white noise of variance 1.
struct Gain {
  double variance = 1.0;
  double dof = 1.0;  ///< degrees of freedom per coefficient
};

double LaggedProduct(const Taps& taps, std::size_t lag) {
  double sum = 0.0;
  for (std::size_t k = 0; k + lag < taps.size(); ++k) sum += taps[k] * taps[k + lag];
  return sum;
}

/// Returns the gain of coefficients with these taps, one every `step` samples.
Gain ComputeGain(const Taps& taps, std::size_t step) {
  const double variance = LaggedProduct(taps, 0);
  double sum = 1.0;
  for (std::size_t lag = step; lag < taps.size(); lag += step) {
    sum += 2.0 * std::pow(LaggedProduct(taps, lag) / variance, 2);
  }
  return {variance, 1.0 / sum};
}

std::array<Gain, kImuOctaves> Gains(ImuSampling sampling) {
  const Taps sampled = sampling == ImuSampling::kMean ? Taps{1.0} : Taps{0.5, 0.5};
  return {ComputeGain(Convolved(sampled, WaveletFilter(), 1), 2),
          ComputeGain(Convolved(Convolved(sampled, ScalingFilter(), 1), WaveletFilter(), 2), 4)};
}

/// Range of samples without a hole between them: [first, past).
struct Stretch {
  std::size_t first, past;
};

bool IsRegular(const ImuData& imu, std::size_t k) {
  constexpr double kLongest = 1.5, kShortest = 0.5;
  const double dt_s = imu.samples[k].dt_s / imu.nominal_dt_s;
  return dt_s > kShortest && dt_s < kLongest;
}

bool FollowsRegularly(const ImuData& imu, std::size_t k) {
  constexpr double kLongest = 1.5;
  return IsRegular(imu, k) &&
         imu.samples[k].t_s - imu.samples[k - 1].t_s < kLongest * imu.nominal_dt_s;
}

/// Returns true if the sample is so close to an end of a vibration that filters would mix both
/// sides.
bool IsAtEdge(const ImuSample& sample, const ImuModel& model, double margin_s) {
  return std::any_of(model.vibration.begin(), model.vibration.end(), [&](const ImuVibration& v) {
    return std::abs(sample.t_s - v.t0_s) <= margin_s || std::abs(sample.t_s - v.t1_s) <= margin_s;
  });
}

std::vector<Stretch> Stretches(const ImuData& imu, const ImuModel& model, double margin_s) {
  std::vector<Stretch> stretches;
  for (std::size_t k = 0; k < imu.samples.size(); ++k) {
    if (!IsRegular(imu, k) || IsAtEdge(imu.samples[k], model, margin_s)) continue;
    const bool goes_on =
        !stretches.empty() && stretches.back().past == k && FollowsRegularly(imu, k);
    if (!goes_on) stretches.push_back({k, k});
    stretches.back().past = k + 1;
  }
  return stretches;
}

/// Returns the variance that the vibrations of the model add at a time.
double AddedVariance(double t_s, ImuTriad triad, const ImuModel& model) {
  double variance = 0.0;
  for (const ImuVibration& v : model.vibration) {
    const double sigma = triad == kGyroTriad ? v.gyro_sigma_radps : v.accel_sigma_mps2;
    if (v.Covers(t_s)) variance += sigma * sigma;
  }
  return variance;
}

const Eigen::Vector3d& TriadValue(const ImuSample& sample, ImuTriad triad) {
  return triad == kGyroTriad ? sample.w_ib_b_radps : sample.f_b_mps2;
}

std::vector<double> AxisValues(const ImuData& imu, const Stretch& stretch, ImuTriad triad,
                               Eigen::Index axis) {
  std::vector<double> values;
  values.reserve(stretch.past - stretch.first);
  for (std::size_t k = stretch.first; k < stretch.past; ++k) {
    values.push_back(TriadValue(imu.samples[k], triad)[axis]);
  }
  return values;
}

double RepeatedShare(const ImuData& imu, ImuTriad triad) {
  std::size_t repeated = 0;
  for (std::size_t k = 1; k < imu.samples.size(); ++k) {
    if (TriadValue(imu.samples[k], triad) == TriadValue(imu.samples[k - 1], triad)) ++repeated;
  }
  return static_cast<double>(repeated) / static_cast<double>(imu.samples.size());
}

std::vector<double> Differences(const ImuData& imu, ImuTriad triad, Eigen::Index axis) {
  std::vector<double> differences;
  for (std::size_t k = 1; k < imu.samples.size(); ++k) {
    const double d = std::abs(TriadValue(imu.samples[k], triad)[axis] -
                              TriadValue(imu.samples[k - 1], triad)[axis]);
    if (d > 0.0) differences.push_back(d);
  }
  return differences;
}

/// Returns the largest step that divides all differences of successive values, apart from the
/// rounding of the file. Returns 0 if there is no such step, or if it is too small to matter.
double Resolution(const ImuData& imu, ImuTriad triad, Eigen::Index axis) {
  /// Smallest step that matters, in medians of the differences; a finer step adds no relevant
  /// noise.
  constexpr double kLeastStep = 0.02;
  constexpr double kNearMultiple = 0.1, kMultiplesShare = 0.95;
  const std::vector<double> differences = Differences(imu, triad, axis);
  if (differences.empty()) return 0.0;
  const double least = kLeastStep * Median(differences);
  double step = std::numeric_limits<double>::infinity();
  for (const double d : differences) {
    if (d > least) step = std::min(step, d);
  }
  const auto multiples = std::count_if(differences.begin(), differences.end(), [&](double d) {
    return std::abs(d / step - std::round(d / step)) < kNearMultiple;
  });
  const bool stepped =
      static_cast<double>(multiples) > kMultiplesShare * static_cast<double>(differences.size());
  return stepped ? step : 0.0;
}

std::vector<HighBandWindow> EmptyWindows(const ImuData& imu, double window_s) {
  const double span_s = imu.t_end_s() - imu.t_begin_s();
  std::vector<HighBandWindow> windows(
      static_cast<std::size_t>(std::max(1.0, std::ceil(span_s / window_s - 1e-6))));
  for (std::size_t k = 0; k < windows.size(); ++k) {
    windows[k].t0_s = imu.t_begin_s() + static_cast<double>(k) * window_s;
    windows[k].t1_s = std::min(windows[k].t0_s + window_s, imu.t_end_s());
  }
  return windows;
}

/// Adds the coefficients of one triad to the windows.
class Collector {
 public:
  Collector(const ImuData& imu, const ImuModel& model, const HighBandOptions& options,
            double assumed_variance, ImuTriad triad, std::vector<HighBandWindow>* windows)
      : imu_(imu),
        model_(model),
        options_(options),
        assumed_variance_(assumed_variance),
        triad_(triad),
        gains_(Gains(options.sampling)),
        windows_(*windows) {}

  void Add(const Stretch& stretch) {
    variance_ = assumed_variance_ + AddedVariance(imu_.samples[stretch.first].t_s, triad_, model_);
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      const std::vector<double> x = AxisValues(imu_, stretch, triad_, axis);
      const double t_s = 0.5 * (imu_.samples[stretch.first].t_s + Begin(stretch));
      const double dt_s = imu_.nominal_dt_s;
      const double middle = 0.5 * (kTaps - 1);
      AddOctave(Halved(x, WaveletFilter()), kTopOctave, axis, t_s + middle * dt_s, 2.0 * dt_s);
      AddOctave(Halved(Halved(x, ScalingFilter()), WaveletFilter()), kSecondOctave, axis,
                t_s + 3.0 * middle * dt_s, 4.0 * dt_s);
    }
  }

 private:
  double Begin(const Stretch& stretch) const {
    return imu_.samples[stretch.first].t_s - imu_.samples[stretch.first].dt_s;
  }

  void AddOctave(const std::vector<double>& coefficients, ImuOctave octave, Eigen::Index axis,
                 double t_s, double step_s) {
    const Gain& gain = gains_[octave];
    for (const double c : coefficients) {
      const double since_s = t_s - windows_.front().t0_s;
      t_s += step_s;
      const auto window = static_cast<std::size_t>(std::max(0.0, since_s / options_.window_s));
      BandEnergy& energy = windows_[std::min(window, windows_.size() - 1)]
                               .energy[triad_][static_cast<std::size_t>(axis)][octave];
      energy += {gain.dof * c * c / (gain.variance * variance_), gain.dof};
    }
  }

  const ImuData& imu_;
  const ImuModel& model_;
  const HighBandOptions& options_;
  double assumed_variance_;
  double variance_ = 0.0;  ///< variance of the current stretch
  ImuTriad triad_;
  std::array<Gain, kImuOctaves> gains_;
  std::vector<HighBandWindow>& windows_;
};

std::string Repeats(double share) {
  char text[64];
  std::snprintf(text, sizeof(text), "%.0f %% of its samples repeat the sample before",
                100.0 * share);
  return text;
}

/// Returns the variance from rounding, mean of the axes. A step seen in means of two point samples
/// is half the step of the samples.
double RoundingVariance(const ImuData& imu, ImuTriad triad, ImuSampling sampling) {
  double sum = 0.0;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const double step = (sampling == ImuSampling::kMean ? 1.0 : 2.0) * Resolution(imu, triad, axis);
    sum += step * step / 12.0 / 3.0;
  }
  return sum;
}

BandEnergy Total(const std::vector<HighBandWindow>& windows, ImuTriad triad, ImuOctave octave) {
  BandEnergy total;
  for (const HighBandWindow& window : windows) {
    for (const auto& axis : window.energy[triad]) total += axis[octave];
  }
  return total;
}

/// Returns the reason why the energies do not show the noise of a triad; empty if they do.
std::string Unusable(const TriadSamples& samples, const std::vector<HighBandWindow>& windows,
                     ImuTriad triad) {
  BandEnergy total = Total(windows, triad, kSecondOctave);
  if (!(total.dof > 0.0)) return "it has no continuous samples at equal intervals";
  total += Total(windows, triad, kTopOctave);
  const double coarsest = kCoarsestResolution * kCoarsestResolution / 12.0;
  if (samples.rounding > coarsest * (1.0 + samples.rounding) * total.Variance()) {
    return "its resolution is coarser than its noise";
  }
  if (samples.repeated_share > kMostRepeated) return Repeats(samples.repeated_share);
  return {};
}

void Measure(const ImuData& imu, const ImuModel& model, ImuTriad triad,
             const HighBandOptions& options, HighBand* band) {
  const double white = triad == kGyroTriad ? model.gyro.white : model.accel.white;
  TriadSamples& samples = band->triads[triad];
  samples.assumed_sigma = white / std::sqrt(imu.nominal_dt_s);
  const double variance = samples.assumed_sigma * samples.assumed_sigma;
  samples.rounding = RoundingVariance(imu, triad, options.sampling) / variance;
  samples.repeated_share = RepeatedShare(imu, triad);
  Collector collector(imu, model, options, variance * (1.0 + samples.rounding), triad,
                      &band->windows);
  for (const Stretch& stretch : Stretches(imu, model, options.window_s)) collector.Add(stretch);
  samples.unusable = Unusable(samples, band->windows, triad);
  if (samples.unusable.empty()) return;
  for (HighBandWindow& window : band->windows) window.energy[triad] = {};
}

}  // namespace

BandEnergy& BandEnergy::operator+=(const BandEnergy& other) {
  sum += other.sum;
  dof += other.dof;
  return *this;
}

BandEnergy HighBandWindow::Total(ImuTriad triad) const {
  BandEnergy total;
  for (const auto& axis : energy[triad]) {
    for (const BandEnergy& octave : axis) total += octave;
  }
  return total;
}

void HighBandOptions::Validate() const {
  if (!(window_s > 0.0) || !std::isfinite(window_s)) {
    throw InvalidConfig("high band: option window_s is " + std::to_string(window_s) +
                        " s, but must be positive and finite");
  }
}

HighBand MeasureHighBand(const ImuData& imu, const ImuModel& model,
                         const HighBandOptions& options) {
  options.Validate();
  Validate(model);
  HighBandOptions used = options;
  used.window_s = std::max(options.window_s, (imu.t_end_s() - imu.t_begin_s()) / kMostWindows);
  HighBand band;
  band.windows = EmptyWindows(imu, used.window_s);
  Measure(imu, model, kGyroTriad, used, &band);
  Measure(imu, model, kAccelTriad, used, &band);
  return band;
}

}  // namespace dn
