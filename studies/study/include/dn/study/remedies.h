#pragma once

#include <dn/study/study.h>

#include <atomic>
#include <future>
#include <map>
#include <string>
#include <vector>

namespace dn {

/// The changes that a scenario calls for, what its strips have in common varied by one more strip, and
/// twice the pairs. They are tried side by side from the beginning on, by all threads but one. None
/// for the replay of a trajectory.
class RemedyTrials {
 public:
  /// Of a scenario and the design that was made of it.
  RemedyTrials(const Scenario& scenario, const StudyDesign& design, const DesignOptions& options);
  ~RemedyTrials();

  /// Tries what is left and fills StudyDirection::tried. Changes that cannot be flown, and those that
  /// leave the design singular, are left out. Once.
  void Finish(StudyResult* study);

 private:
  /// Sigmas of the calibration unknowns by name, in their units; none where there are none to be had.
  using Sigmas = std::map<std::string, double>;

  static Sigmas SigmasWith(const Scenario& scenario, const DesignOptions& options);
  void Prepare(const Scenario& scenario, const FlightGeometry& geometry);
  void Work();

  DesignOptions options_;
  bool fewer_nodes_ = false;  // than the design itself has
  std::vector<RemedyKind> kinds_;
  std::vector<Scenario> scenarios_;  // of the kinds, then, with fewer nodes, the unchanged one
  std::vector<Sigmas> sigmas_;       // of the scenarios
  std::atomic<std::size_t> next_{0};
  std::vector<std::future<void>> workers_;
};

}  // namespace dn
