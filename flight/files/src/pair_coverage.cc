#include "pair_coverage.h"

#include <dn/error.h>
#include <dn/geo/median_step.h>
#include <dn/geo/text_table.h>
#include <dn/geo/week_seconds.h>

#include <algorithm>
#include <cmath>

namespace dn::files_internal {
namespace {

constexpr double kHoleS = 1.0;
constexpr double kHoleSteps = 5.0;

std::string Seconds(double t_s) { return FormatDouble(std::round(t_s * 1e6) / 1e6); }

FileLocation PairLocation(const LidarPair& pair, const PairData& data) {
  return {data.files[static_cast<std::size_t>(pair.file)].string(), pair.line, 0};
}

[[noreturn]] void FailOutside(double t_s, const char* epoch, const LidarPair& pair,
                              const PairData& data, const CoveredTime& covered) {
  const std::string unit = ClockHint(t_s, covered, "lidar");
  throw InvalidInput(
      std::string("pair epoch ") + epoch + " = " + Seconds(t_s) + " s lies outside " +
          covered.what + " (" + SpanText(covered.t_begin_s, covered.t_end_s) + ")" +
          (unit.empty() ? "; check the time system of the pair file, or remove such pairs" : unit),
      PairLocation(pair, data));
}

/// Returns the gap that contains an epoch of the pair; null if there is none.
const ImuGap* PairGap(const LidarPair& pair, const CoveredTime& covered) {
  const ImuGap* hole = covered.GapAt(pair.t_i_s);
  return hole != nullptr ? hole : covered.GapAt(pair.t_j_s);
}

[[noreturn]] void FailInGaps(long count, const PairData& data, const CoveredTime& covered) {
  const auto first = std::find_if(data.pairs.begin(), data.pairs.end(), [&](const LidarPair& pair) {
    return PairGap(pair, covered) != nullptr;
  });
  const ImuGap& hole = *PairGap(*first, covered);
  throw InvalidInput(std::to_string(count) + " of " + std::to_string(data.pairs.size()) +
                         " pairs have an epoch in a gap of " + covered.what + ", the first in " +
                         SpanText(hole.t_begin_s, hole.t_end_s) +
                         "; check the time system of the pair file and the gaps of the data",
                     PairLocation(*first, data));
}

}  // namespace

std::string ClockHint(double t_s, const CoveredTime& covered, const std::string& key) {
  std::string unit = TimeUnitHint(t_s, covered.t_begin_s, covered.t_end_s);
  if (!unit.empty() || covered.InSpan(t_s)) return unit;
  constexpr double kHourS = 3600.0;
  constexpr int kMostHours = 6 * 24, kMostZone = 14;
  for (int hours = 1; hours <= kMostHours; ++hours) {
    if (hours > kMostZone && hours % 24 != 0) continue;
    for (const double shift_s : {hours * kHourS, -hours * kHourS}) {
      if (!covered.InSpan(t_s + shift_s)) continue;
      const std::string by = hours % 24 == 0 && hours > 24 ? std::to_string(hours / 24) + " days"
                                                           : std::to_string(hours) + " hours";
      std::string hint = "; it would lie inside ";
      hint.append(by).append(shift_s > 0.0 ? " later" : " earlier");
      hint.append(": check the time zone and the day, or set ").append(key);
      return hint.append(".time_offset_s: ").append(FormatDouble(-shift_s));
    }
  }
  return {};
}

std::string SpanText(double t_begin_s, double t_end_s) {
  return Seconds(t_begin_s) + " .. " + Seconds(t_end_s) + " s";
}

const ImuGap* CoveredTime::GapAt(double t_s) const {
  const auto after =
      std::upper_bound(holes.begin(), holes.end(), t_s,
                       [](double t, const ImuGap& hole) { return t < hole.t_end_s; });
  return after != holes.end() && t_s > after->t_begin_s ? &*after : nullptr;
}

CoveredTime Cover(const ImuData& imu) {
  return {"the IMU data", imu.t_begin_s(), imu.t_end_s(), imu.gaps, "IMU gaps"};
}

CoveredTime Cover(const Trajectory& trajectory) {
  CoveredTime covered{
      "the trajectory", trajectory.t_begin_s(), trajectory.t_end_s(), {}, "trajectory gaps"};
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

long CountOutside(const PairData& data, const CoveredTime& covered) {
  return std::count_if(data.pairs.begin(), data.pairs.end(), [&](const LidarPair& pair) {
    return !covered.InSpan(pair.t_i_s) || !covered.InSpan(pair.t_j_s);
  });
}

long CountInGaps(const PairData& data, const CoveredTime& covered) {
  return std::count_if(data.pairs.begin(), data.pairs.end(), [&](const LidarPair& pair) {
    return covered.InSpan(pair.t_i_s) && covered.InSpan(pair.t_j_s) &&
           PairGap(pair, covered) != nullptr;
  });
}

void ExpectInSpan(const PairData& data, const CoveredTime& covered) {
  for (const LidarPair& pair : data.pairs) {
    if (!covered.InSpan(pair.t_i_s)) FailOutside(pair.t_i_s, "t_i", pair, data, covered);
    if (!covered.InSpan(pair.t_j_s)) FailOutside(pair.t_j_s, "t_j", pair, data, covered);
  }
}

long DropInGaps(const CoveredTime& covered, PairData& data) {
  const long in_holes = CountInGaps(data, covered);
  if (2 * in_holes > static_cast<long>(data.pairs.size())) FailInGaps(in_holes, data, covered);
  return static_cast<long>(std::erase_if(
      data.pairs, [&](const LidarPair& pair) { return PairGap(pair, covered) != nullptr; }));
}

}  // namespace dn::files_internal
