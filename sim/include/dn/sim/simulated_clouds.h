#pragma once

#include <dn/files/flight_config.h>
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

/// Numbers of pulses and points of a strip.
struct CloudCounts {
  std::uint64_t pulses = 0;
  std::uint64_t points = 0;
  /// Pulses lost on water. All other lost pulses missed the surface or nearly grazed it.
  std::uint64_t on_water = 0;
};

/// Point clouds of a simulated flight. They are computed when they are written, because the pulses
/// of a flight do not fit into memory. A pulse has the true epoch t. With the true trajectory,
/// boresight theta, lever arm a and beam direction d in the sensor frame (ScanTiming):
///
///   range r:  p_mb + R_mb (a + r Exp([theta]x) R_bs d')  is the first point of the surface
///   u = measured(r d) + noise along the beam
///   p = p_mb + R_mb (R_bs u + a'), at the epoch t + tag shift
///
/// where
///
///   d'          d rotated by a random angle of divergence / 4 about each of two axes: the place in
///               the footprint from which the return comes
///   measured()  the lidar effects
///   R_bs, a'    R_bs_nominal of the mounting, and assumed lever arm
///
/// Software computes the points p in this way before a calibration.
class SimulatedClouds {
 public:
  /// span: true lidar epochs to which the effects refer.
  SimulatedClouds(const Scenario& scenario, std::vector<StripInterval> strips,
                  std::shared_ptr<const TruthTrajectory> truth, const ActiveEffects& effects,
                  const LidarSpan& span, std::uint64_t seed, bool noise);
  ~SimulatedClouds();

  const std::vector<StripInterval>& strips() const { return strips_; }

  /// Simulates the pulses of a strip. `take` receives its points in time order, in groups of about
  /// 10,000. The result does not depend on the number of threads. `progress` receives the fraction
  /// done and may throw to stop the work.
  CloudCounts Run(std::size_t strip, int threads,
                  const std::function<void(const StripCloud&)>& take,
                  const std::function<void(double fraction)>& progress) const;

  /// Writes the points to a LAS file (NewLasStrip) in m. The point source is the number of the
  /// strip.
  CloudCounts Write(std::size_t strip, const std::filesystem::path& file, int threads,
                    const std::function<void(double fraction)>& progress) const;

 private:
  class Pulses;
  struct World;

  std::vector<StripInterval> strips_;
  std::unique_ptr<const World> world_;
};

}  // namespace dn
