#pragma once

#include <dn/builder/calibration_effect.h>
#include <dn/files/flight.h>
#include <dn/linear_prior.h>

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace dn {

/// Corrections of the beams of a scanner: a block with one value per beam.
///
///   lidar_beam_angle   rad; true angle of the beam toward +scan_axis = that of its vectors + value
///   lidar_beam_range   m; measured range = true range + value
///
/// Their prior is that of independent errors without the mean over the beams that measured pairs.
/// A mean angle is a boresight or a lidar_scan_cone, a mean range is a lidar_range_offset. The mean
/// of the corrections of these beams is therefore zero.
struct BeamUnknown {
  enum class Kind { kAngle, kRange };
  Kind kind = Kind::kAngle;
  std::size_t scanner = 0;
  std::string name;        ///< of the block: lidar_beam_angle or lidar_beam_range, see ScannerName
  double sigma = 0.0;      ///< prior of each beam before the mean is removed, SI
  std::vector<long> ends;  ///< number of ends of pairs that each beam measured

  std::size_t num_beams() const { return ends.size(); }
  /// Returns the number of beams that measured pairs.
  std::size_t NumMeasured() const;
  /// Returns the standard deviation that beam k has before any data, SI.
  double PriorSigma(std::size_t k) const;
};

/// Returns the unknowns of a scanner whose beams measured `ends` ends of pairs or points of planes;
/// none if the scanner has no `beams` in flight.yaml or no beam measured anything. Throws
/// InvalidInput if `ends` has more beams than the scanner. `what` is an end in the message: "a
/// pair".
std::vector<BeamUnknown> MakeBeamUnknowns(const FlightConfig& config, std::size_t scanner,
                                          std::vector<long> ends, const char* what);

/// Returns the unknowns of the scanners that have `beams` in flight.yaml and pairs with beams.
std::vector<BeamUnknown> FindBeamUnknowns(const Flight& flight);

/// Returns whether a block has the name of such an unknown.
bool IsBeamUnknown(std::string_view name);

/// Returns the action of these corrections on the readings of their scanner; readings without a
/// beam stay unchanged.
EffectAction BeamAction(const Flight& flight, const BeamUnknown& unknown);

/// Returns the prior of the block.
LinearPrior BeamPrior(const BeamUnknown& unknown);

}  // namespace dn
