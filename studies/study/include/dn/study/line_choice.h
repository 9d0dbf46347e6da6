#pragma once

#include <dn/report/json.h>
#include <dn/study/study.h>

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <string>
#include <vector>

namespace dn {

/// Candidate lines, from which the shortest flight that determines the boresight to a target is
/// chosen.
///
///   base: lar3                       # a shipped scenario, or a file in this folder; its lines are
///                                    # not used
///   estimate: [gnss_lever_arm]       # estimated with the boresight; default: nothing
///   target_deg: [0.002, 0.002, 0.005]     # largest sigmas of roll, pitch, yaw
///   lines:                           # 2 to 12 lines, by name:
///                                    # east0, north0, east1, north1, height [m], speed [m/s]
///     east: [-1500, 0, 1500, 0, 700, 45]
///     across: [0, -1500, 0, 1500, 760, 45]
struct LineCandidates {
  Scenario scenario;               ///< flies all lines, in the order of the file
  std::vector<std::string> names;  ///< names of the lines of the scenario
  std::string estimate;
  Eigen::Vector3d target_rad = Eigen::Vector3d::Zero();
  double pairs_per_line = 0.0;  ///< as in the base scenario

  /// Reads the candidates. `where` is the file, named in messages. Throws InvalidConfig for an
  /// unknown key, an invalid base, and a base that replays a trajectory. Also throws for fewer
  /// than 2 or more than 12 lines, lines that cannot be flown, and a target that is not positive.
  static LineCandidates Parse(const std::string& yaml_text, const std::string& where);

  /// Returns the scenario with some of the lines, by index and in this order.
  Scenario With(const std::vector<std::size_t>& lines) const;
};

/// A choice of candidate lines, and the sigmas that it gives.
struct LineChoice {
  std::vector<std::size_t> lines;  ///< indices, ascending
  double flight_time_s = 0.0;      ///< duration of the whole flight, with warm-up and turns
  std::string failure;             ///< reason why it is singular, without sigmas; else empty
  Eigen::Vector3d sigma_rad = Eigen::Vector3d::Zero();

  /// Returns the largest ratio of a sigma and its target; infinity for a failure.
  double WorstRatio(const Eigen::Vector3d& target_rad) const;
};

/// The choices that were studied, and the best of them.
struct LineSearch {
  std::vector<LineChoice> studied;  ///< sorted by flight time
  /// Index of the shortest flight that meets the target; -1 if not even all lines meet it.
  std::ptrdiff_t best = -1;
};

/// Options of the search.
struct LineSearchOptions {
  DesignOptions design;
  /// Called with the number of choices studied so far.
  std::function<void(std::size_t studied)> progress = nullptr;
};

/// Finds the shortest flight that meets the target, over some of the lines. They are flown in their
/// order, each with the same number of pairs. One more line is assumed to make no angle worse, so
/// parts of a choice that misses the target are not studied. Leaving out one line after the other
/// gives a first solution; then all shorter choices are studied in the order of their flight time.
///
/// The result does not depend on the number of threads. Throws InvalidConfig for lines that cannot
/// be flown, and Interrupted.
LineSearch ChooseLines(const LineCandidates& candidates, const LineSearchOptions& options = {});

/// Returns optimise.json (schema dn.optimise/1).
Json ToJson(const LineCandidates& candidates, const LineSearch& search);

/// Returns a table with the best choice for each number of lines, and the lines to fly.
std::string LineSearchSummary(const LineCandidates& candidates, const LineSearch& search);

/// Returns the angles that miss the target even with all lines, and by how much. If the flight with
/// all lines is singular, returns the reason.
std::string MissedTarget(const LineCandidates& candidates, const LineSearch& search);

/// Returns designs.csv with a row for each choice studied.
std::string LineSearchCsv(const LineCandidates& candidates, const LineSearch& search);

}  // namespace dn
