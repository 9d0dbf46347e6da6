#pragma once

#include <dn/flight/flight.h>
#include <dn/gap/diagnosis.h>
#include <dn/geo/trajectory.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace dn {

/// How a flight is diagnosed.
struct GapOptions {
  enum class Depth {
    kFull,    ///< everything
    kQuick,   ///< fewer twins
    kScreen,  ///< what the data show, without refits and without simulated twins
    kLimits,  ///< what could be found; needs no measured values
  };
  Depth depth = Depth::kFull;
  std::uint64_t seed = 1;  ///< of the twins
  double alpha = 0.05;     ///< of the claim that there is a gap
  int threads = 1;
  /// Only these effects are considered; empty: the whole library.
  std::vector<std::string> effects = {};
  /// Effects that the library does without.
  std::vector<std::string> left_out = {};
  /// Called when a stage begins, with the part of the work that is done.
  std::function<void(const std::string& stage, double fraction)> progress = {};
  /// Polled between steps; true ends the work with Interrupted.
  std::function<bool()> interrupted = {};

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// A diagnosis with both halves of "once the effects are added".
struct GapResult {
  GapDiagnosis diagnosis;
  FlightConfig adapted;   ///< the flight with the verdict's effects in the estimator
  Trajectory trajectory;  ///< the estimated one, with them: what a twin replays
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< likewise, total
};

/// Diagnoses a flight that was read with its IMU and GNSS data, and pairs where it has any: whether
/// the data depart from what the assumed model would produce, where, by which effect, how far the
/// gap closes once that is added, and what could still hide (docs/method/gap-method.md). The same
/// for the same seed and number of threads. Throws as Adjust, and InvalidConfig for bad options.
GapResult Diagnose(const Flight& flight, const GapOptions& options = {});

}  // namespace dn
