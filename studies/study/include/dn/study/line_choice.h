#pragma once

#include <dn/report/json.h>
#include <dn/study/study.h>

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace dn {

/// Lines of which the fewest seconds of flight are to be chosen that determine the boresight.
///
///   base: lar3                       # a shipped scenario, or a file beside this one; its lines do not count
///   estimate: [gnss_lever_arm]       # what is free beside the boresight; default: nothing
///   target_deg: [0.002, 0.002, 0.005]     # largest sigmas of roll, pitch, yaw
///   lines:                           # 2 to 12: name: east0, north0, east1, north1, height [m], speed [m/s]
///     east: [-1500, 0, 1500, 0, 700, 45]
///     across: [0, -1500, 0, 1500, 760, 45]
struct LineCandidates {
  Scenario scenario;               ///< flies all of them, in the order of the file
  std::vector<std::string> names;  ///< of the lines of the scenario
  std::string estimate;
  Eigen::Vector3d target_rad = Eigen::Vector3d::Zero();
  double pairs_per_line = 0.0;  ///< as in the base

  /// Throws InvalidConfig for an unknown key, a base that is no scenario or flies a replay, fewer
  /// than 2 or more than 12 lines, lines that cannot be flown, a target that is not positive.
  static LineCandidates Parse(const std::string& yaml_text, const std::string& where);

  /// The scenario with some of the lines, by index and in this order.
  Scenario With(const std::vector<std::size_t>& lines) const;
};

/// Some of the candidates, and what they determine.
struct LineChoice {
  std::vector<std::size_t> lines;  ///< indices, ascending
  double flight_time_s = 0.0;      ///< of the whole flight, with warm-up and turns
  std::string failure;             ///< why it is singular; no sigmas then
  Eigen::Vector3d sigma_rad = Eigen::Vector3d::Zero();

  /// Largest ratio of a sigma and its target; infinite for a failure.
  double WorstRatio(const Eigen::Vector3d& target_rad) const;
};

/// The choices that were studied, and the best one.
struct LineSearch {
  std::vector<LineChoice> studied;  ///< by flight time
  /// Index of the shortest flight that meets the target; none: not even all lines do.
  std::ptrdiff_t best = -1;
};

/// How the search is done, and whom it tells.
struct LineSearchOptions {
  DesignOptions design;
  /// Called with the number of choices studied so far.
  std::function<void(std::size_t studied)> progress = nullptr;
};

/// Finds the shortest flight over some of the lines, flown in their order, each with the same number
/// of pairs, that meets the target. A line more is taken to make no angle worse: of choices that
/// miss the target no part is studied. Exhaustive under that: choices that are longer than one found
/// by leaving out one line after the other are not studied, all shorter ones are, by flight time.
/// The same for any number of threads. Throws InvalidConfig for lines that cannot be flown.
LineSearch ChooseLines(const LineCandidates& candidates, const LineSearchOptions& options = {});

/// optimise.json (schema dn.optimise/1).
Json ToJson(const LineCandidates& candidates, const LineSearch& search);

/// A row for the best choice of each number of lines, and what to fly.
std::string LineSearchSummary(const LineCandidates& candidates, const LineSearch& search);

/// Which angles miss the target with all lines, and by how much; why, where they are singular.
std::string MissedTarget(const LineCandidates& candidates, const LineSearch& search);

/// designs.csv: a row per choice that was studied.
std::string LineSearchCsv(const LineCandidates& candidates, const LineSearch& search);

}  // namespace dn
