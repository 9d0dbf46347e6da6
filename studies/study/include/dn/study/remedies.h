#pragma once

#include <dn/study/study.h>

#include <atomic>
#include <future>
#include <map>
#include <string>
#include <vector>

namespace dn {

/// Trials of changes that may improve a scenario: one more strip that varies a common property of
/// the strips, and twice the pairs. All threads but one try them in parallel from the construction
/// on. There are no trials for the replay of a trajectory.
class RemedyTrials {
 public:
  /// Starts the trials. `design` must have been made from the scenario.
  RemedyTrials(const Scenario& scenario, const StudyDesign& design, const DesignOptions& options);
  ~RemedyTrials();

  /// Tries the remaining changes and fills StudyDirection::tried. Leaves out changes that cannot be
  /// flown or make the design singular. Call it once.
  void Finish(StudyResult* study);

 private:
  /// Sigmas of the calibration unknowns by name, in their units; empty if the scenario has none.
  using Sigmas = std::map<std::string, double>;

  static Sigmas SigmasWith(const Scenario& scenario, const DesignOptions& options);
  void Prepare(const Scenario& scenario, const FlightGeometry& geometry);
  void Work();

  DesignOptions options_;
  bool fewer_nodes_ = false;  // fewer than the design itself
  std::vector<RemedyKind> kinds_;
  std::vector<Scenario> scenarios_;  // one per kind; with fewer nodes, the unchanged scenario last
  std::vector<Sigmas> sigmas_;       // one per scenario
  std::atomic<std::size_t> next_{0};
  std::vector<std::future<void>> workers_;
};

}  // namespace dn
