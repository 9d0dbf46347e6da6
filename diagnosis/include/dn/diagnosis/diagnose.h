#pragma once

#include <dn/diagnosis/diagnosis.h>
#include <dn/files/flight.h>
#include <dn/geo/trajectory.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace dn {

/// Options of a diagnosis.
struct GapOptions {
  enum class Depth {
    kFull,    ///< all stages
    kQuick,   ///< fewer replicates
    kScreen,  ///< screening only: no refits, no simulated replicates
    kLimits,  ///< detection limits only; needs no measured values
  };
  Depth depth = Depth::kFull;
  std::uint64_t seed = 1;  ///< seed of the replicates
  double alpha = 0.05;     ///< significance level (false-alarm rate) of the gap test
  /// Prior probability that what happened to the flight is not in the library, if something did.
  double outside = 0.2;
  int threads = 1;
  /// Only these effects are considered; empty: the whole library.
  std::vector<std::string> effects = {};
  /// Effects excluded from the library.
  std::vector<std::string> left_out = {};
  /// Called at the start of each stage with the fraction of the work done so far.
  std::function<void(const std::string& stage, double fraction)> progress = {};
  /// Polled between steps; returning true aborts the diagnosis with Interrupted.
  std::function<bool()> interrupted = {};

  /// Throws InvalidConfig naming the option, its value and its bound.
  void Validate() const;
};

/// A diagnosis, and the flight with the effects of its verdict added.
struct GapResult {
  GapDiagnosis diagnosis;
  FlightConfig adapted;  ///< the flight's configuration with the verdict's effects in the estimator
  Trajectory trajectory;  ///< estimated with these effects; replayed by a replicate
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();  ///< estimated with these effects, total
};

/// Diagnoses a flight whose IMU and GNSS data, and pairs if it has any, have been read. Tests
/// whether the data agree with the assumed model, where they do not, and which effects explain the
/// gap. Also computes how far the gap closes with these effects, and which effects remain
/// undetectable (docs/method/gap-method.md). Results are reproducible for equal seeds and numbers
/// of threads. Throws as Adjust, and InvalidConfig for invalid options.
GapResult Diagnose(const Flight& flight, const GapOptions& options = {});

}  // namespace dn
