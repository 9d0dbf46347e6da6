#include <dn/error.h>
#include <dn/imu/noise_check.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "noise_evidence.h"
#include "window_scan.h"

namespace dn {
namespace {

constexpr double kLeastGroup_s = 2.0;
constexpr std::size_t kMostGroups = 500;
constexpr double kFewestDof = 20.0;  ///< a level needs at least this many

/// Returns the number of cells in a group. A group lasts two seconds, or more in a long flight.
std::size_t GroupSize(const HighBand& band) {
  const std::size_t cells = band.windows.size();
  const double cell_s =
      (band.windows.back().t1_s - band.windows.front().t0_s) / static_cast<double>(cells);
  const auto of_time = static_cast<std::size_t>(std::ceil(kLeastGroup_s / cell_s - 1e-6));
  return std::max({std::size_t{1}, of_time, (cells + kMostGroups - 1) / kMostGroups});
}

/// Results of one triad on its own.
class TriadCheck {
 public:
  TriadCheck(const HighBand& band, ImuTriad triad, const RunningSums& sums)
      : band_(band), triad_(triad), sums_(sums), levels_(band.triads[triad].rounding) {}

  LogLevel Whole() const { return levels_.Level(sums_.All()); }

  NoiseLevel Level() const {
    NoiseLevel level;
    level.ratio = levels_.Ratio(sums_.All());
    level.sigma = levels_.Sigma(sums_.All());
    BandEnergy top, second;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      BandEnergy both = Total(axis, kTopOctave);
      top += both;
      second += Total(axis, kSecondOctave);
      both += Total(axis, kSecondOctave);
      level.axis_ratio[axis] = levels_.Ratio(both);
    }
    level.tilt = std::log(top.Variance() / second.Variance());
    level.tilt_sigma = std::sqrt(2.0 / top.dof + 2.0 / second.dof);
    return level;
  }

  std::vector<LogLevel> ByBand() const {
    std::vector<LogLevel> levels;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      levels.push_back(levels_.Level(Total(axis, kTopOctave)));
      levels.push_back(levels_.Level(Total(axis, kSecondOctave)));
    }
    return levels;
  }

  std::vector<LogLevel> ByTime(std::size_t group) const {
    std::vector<LogLevel> levels;
    for (std::size_t first = 0; first < band_.windows.size(); first += group) {
      const BandEnergy energy =
          sums_.Inside({first, std::min(first + group, band_.windows.size())});
      if (energy.dof >= kFewestDof) levels.push_back(levels_.Level(energy));
    }
    return levels;
  }

 private:
  BandEnergy Total(std::size_t axis, ImuOctave octave) const {
    BandEnergy total;
    for (const HighBandWindow& window : band_.windows) total += window.At(triad_, axis, octave);
    return total;
  }

  const HighBand& band_;
  ImuTriad triad_;
  const RunningSums& sums_;
  NoiseLevels levels_;
};

/// Returns the log Bayes factor of the better alternative for each triad: another level, or the
/// assumed one.
double BestScale(const NoiseEvidence& evidence) {
  return std::max(0.0, evidence.scale[kGyroTriad]) + std::max(0.0, evidence.scale[kAccelTriad]);
}

double NotWhite(const NoiseEvidence& evidence, ImuTriad triad) {
  return std::max(evidence.coloured[triad], evidence.unsteady[triad]);
}

double BestForTriad(const NoiseEvidence& evidence, ImuTriad triad) {
  return std::max({0.0, evidence.scale[triad], NotWhite(evidence, triad)});
}

ImuTriad Other(ImuTriad triad) { return triad == kGyroTriad ? kAccelTriad : kGyroTriad; }

/// Returns the largest evidence with at least one triad not white; the other triad uses its best
/// hypothesis.
double BestNotWhite(const NoiseEvidence& evidence) {
  return std::max(NotWhite(evidence, kGyroTriad) + BestForTriad(evidence, kAccelTriad),
                  NotWhite(evidence, kAccelTriad) + BestForTriad(evidence, kGyroTriad));
}

}  // namespace

void NoiseCheckOptions::Validate() const {
  const auto expect = [](bool good, const char* name, double value, const char* bound) {
    if (good) return;
    throw InvalidConfig("noise check: option " + std::string(name) + " is " +
                        std::to_string(value) + ", but must be " + bound);
  };
  expect(typical_ratio > 1.0, "typical_ratio", typical_ratio, "above 1");
  for (const double sigma : typical_sigma) {
    expect(sigma > 0.0, "typical_sigma", sigma, "positive");
  }
  expect(spread_decades > 0.0, "spread_decades", spread_decades, "positive");
}

NoiseHypothesis BestHypothesis(const NoiseEvidence& evidence) {
  // If several are equal, max_element returns the first one, which is the simplest.
  const std::array<double, 5> all{0.0, BestScale(evidence), evidence.window,
                                  evidence.window_and_scale, BestNotWhite(evidence)};
  return static_cast<NoiseHypothesis>(std::max_element(all.begin(), all.end()) - all.begin());
}

NoiseCauses NoiseCauseEvidence(const NoiseEvidence& evidence) {
  const double both = evidence.window_and_scale;
  NoiseCauses causes;
  causes.window = std::max(evidence.window, both) - BestScale(evidence);
  for (const ImuTriad triad : kBothTriads) {
    const double other = BestForTriad(evidence, Other(triad));
    const double scale = evidence.scale[triad];
    causes.scale[triad] = std::max(scale + other, both) - std::max(other, evidence.window);
    causes.not_white[triad] = NotWhite(evidence, triad) + other -
                              std::max({std::max(0.0, scale) + other, evidence.window, both});
  }
  const std::array<double, kImuTriads> price{std::max(0.0, causes.not_white[kGyroTriad]),
                                             std::max(0.0, causes.not_white[kAccelTriad])};
  for (const ImuTriad triad : kBothTriads) causes.scale[triad] -= price[triad];
  causes.window -= std::max(price[kGyroTriad], price[kAccelTriad]);
  return causes;
}

NoiseCheck CheckNoise(const HighBand& band, const NoiseCheckOptions& options) {
  options.Validate();
  NoiseCheck check;
  const RatioPrior prior(options.typical_ratio);
  const std::size_t group = GroupSize(band);
  std::vector<RunningSums> sums;
  bool any = false;
  for (const ImuTriad triad : kBothTriads) sums.emplace_back(band, triad);
  for (const ImuTriad triad : kBothTriads) {
    if (!(sums[triad].All().dof > 0.0)) continue;
    any = true;
    const TriadCheck one(band, triad, sums[triad]);
    check.level[triad] = one.Level();
    check.evidence.scale[triad] = LevelEvidence(one.Whole(), prior);
    check.evidence.coloured[triad] = DifferentLevelsEvidence(one.ByBand(), prior);
    check.evidence.unsteady[triad] = DifferentLevelsEvidence(one.ByTime(group), prior);
  }
  if (!any) return check;
  const WindowScan window(band, options, sums, false, group);
  check.window = window.Likeliest();
  check.evidence.window = window.Evidence();
  const WindowScan beside(band, options, sums, true, group);
  check.window_with_scale = beside.Likeliest();
  check.evidence.window_and_scale = beside.Evidence();
  return check;
}

}  // namespace dn
