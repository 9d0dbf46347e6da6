#include "pair_coverage.h"

#include <dn/error.h>
#include <dn/geo/median_step.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace dn::internal {
namespace {

constexpr double kWeekS = 604800.0;
constexpr double kHoleS = 1.0;
constexpr double kHoleSteps = 5.0;

std::string Seconds(double t_s) {
  char text[48];
  std::snprintf(text, sizeof(text), "%.6f", t_s);
  return text;
}

[[noreturn]] void FailUncovered(double t_s, const char* epoch, const LidarPair& pair,
                                const PairData& data, const CoveredTime& covered) {
  std::string text = std::string("pair epoch ") + epoch + " = " + Seconds(t_s);
  if (const ImuGap* hole = covered.HoleAt(t_s)) {
    text += " s lies in a hole of " + covered.what + " (" +
            SpanText(hole->t_begin_s, hole->t_end_s) + ")";
  } else {
    text += " s lies outside " + covered.what + " (" +
            SpanText(covered.t_begin_s, covered.t_end_s) + ")";
  }
  text += "; check the time system of the pair file, or remove such pairs";
  const auto file = static_cast<std::size_t>(pair.file);
  throw InvalidInput(text, FileLocation{data.files[file].string(), pair.line, 0});
}

}  // namespace

std::string SpanText(double t_begin_s, double t_end_s) {
  return Seconds(t_begin_s) + " .. " + Seconds(t_end_s) + " s";
}

const ImuGap* CoveredTime::HoleAt(double t_s) const {
  const auto after =
      std::upper_bound(holes.begin(), holes.end(), t_s,
                       [](double t, const ImuGap& hole) { return t < hole.t_end_s; });
  return after != holes.end() && t_s > after->t_begin_s ? &*after : nullptr;
}

bool CoveredTime::Contains(double t_s) const {
  return t_s >= t_begin_s && t_s <= t_end_s && HoleAt(t_s) == nullptr;
}

CoveredTime Cover(const ImuData& imu) {
  return {"the IMU data", imu.t_begin_s(), imu.t_end_s(), imu.gaps};
}

CoveredTime Cover(const Trajectory& trajectory) {
  CoveredTime covered{"the trajectory", trajectory.t_begin_s(), trajectory.t_end_s(), {}};
  const std::vector<NavPoint>& points = trajectory.points();
  const double longest_s = std::max(kHoleS, kHoleSteps * MedianStep(points));
  for (std::size_t i = 1; i < points.size(); ++i) {
    if (points[i].t_s - points[i - 1].t_s > longest_s) {
      covered.holes.push_back({points[i - 1].t_s, points[i].t_s});
    }
  }
  return covered;
}

double AlignWeek(double t_s, const CoveredTime& covered) {
  if (t_s < covered.t_begin_s && t_s + kWeekS <= covered.t_end_s) return t_s + kWeekS;
  if (t_s > covered.t_end_s && t_s - kWeekS >= covered.t_begin_s) return t_s - kWeekS;
  return t_s;
}

void AlignWeek(const CoveredTime& covered, std::vector<LidarPair>& pairs) {
  for (LidarPair& pair : pairs) {
    pair.t_i_s = AlignWeek(pair.t_i_s, covered);
    pair.t_j_s = AlignWeek(pair.t_j_s, covered);
  }
}

long CountUncovered(const PairData& data, const CoveredTime& covered) {
  return std::count_if(data.pairs.begin(), data.pairs.end(), [&](const LidarPair& pair) {
    return !covered.Contains(pair.t_i_s) || !covered.Contains(pair.t_j_s);
  });
}

void ExpectCovered(const PairData& data, const CoveredTime& covered) {
  for (const LidarPair& pair : data.pairs) {
    if (!covered.Contains(pair.t_i_s)) FailUncovered(pair.t_i_s, "t_i", pair, data, covered);
    if (!covered.Contains(pair.t_j_s)) FailUncovered(pair.t_j_s, "t_j", pair, data, covered);
  }
}

}  // namespace dn::internal
