#pragma once

#include <dn/flight/flight_config.h>
#include <dn/lidar/strip_cloud.h>
#include <dn/sim/scenario.h>
#include <dn/sim/truth.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

namespace dn {

struct ActiveEffects;
struct LidarSpan;

/// What became of the pulses of a strip.
struct CloudCounts {
  std::uint64_t pulses = 0;
  std::uint64_t points = 0;
  std::uint64_t on_water = 0;  ///< lost there; the others met nothing, or all but grazed it
};

/// The point clouds of a simulated flight, made when they are written: a flight's pulses do not fit
/// into memory. Per pulse at the true epoch t, with the true trajectory, boresight theta, lever arm
/// a and the beam's direction d in the sensor frame (ScanTiming):
///
///   range r:  p_mb + R_mb (a + r Exp([theta]x) T d')  is the first point of the surface
///   u = measured(r d) + noise along the beam
///   p = p_mb + R_mb (T u + a'), at the epoch t + tag shift
///
/// with d' = d turned by a random angle of divergence / 4 about each of two axes (where in the
/// footprint the return comes from), measured() the lidar effects, T the assumed mounting with no
/// boresight and a' its assumed lever arm, by which a processing before calibration makes points.
class SimulatedClouds {
 public:
  /// span: the lidar epochs that effects refer to.
  SimulatedClouds(const Scenario& scenario, std::vector<StripInterval> strips,
                  std::shared_ptr<const TruthTrajectory> truth, const ActiveEffects& effects,
                  const LidarSpan& span, std::uint64_t seed, bool noise);
  ~SimulatedClouds();

  const std::vector<StripInterval>& strips() const { return strips_; }

  /// Pulses of a strip, and its points in the order of time in groups of some 100,000: `take` gets
  /// each group. The same for any number of threads. `progress` is told the fraction done and may
  /// throw to end the work.
  CloudCounts Run(std::size_t strip, int threads,
                  const std::function<void(const StripCloud&)>& take,
                  const std::function<void(double fraction)>& progress) const;

  /// The same into a LAS file (NewLasStrip) in m, the number of the strip as point source.
  CloudCounts Write(std::size_t strip, const std::filesystem::path& file, int threads,
                    const std::function<void(double fraction)>& progress) const;

 private:
  class Pulses;
  struct World;

  std::vector<StripInterval> strips_;
  std::unique_ptr<const World> world_;
};

}  // namespace dn
