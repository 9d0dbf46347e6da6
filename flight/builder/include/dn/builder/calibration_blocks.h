#pragma once

#include <dn/builder/calibration_state.h>
#include <dn/files/flight.h>
#include <dn/network.h>

#include <string>
#include <vector>

namespace dn {

/// An effect that is a block of the network.
struct EffectBlock {
  std::string name;
  EffectAction action;
  BlockId id = -1;
};

/// The blocks of the mounting of one scanner.
struct ScannerBlocks {
  Block<LeftRotation> boresight;
  Block<Vec<3>> lever_arm;
  Block<Vec<1>> time_offset;
};

/// The calibration unknowns of a flight as blocks of a network, with their priors.
///
/// Block names: "boresight", "gnss_lever_arm", "lidar_lever_arm", "lidar_time_offset". Every other
/// effect of `estimate` has its own name, as have the corrections of beams (BeamUnknown). Blocks of
/// further scanners have a ScannerName. A block that the configuration does not estimate is
/// constant.
class CalibrationBlocks {
 public:
  /// Adds the blocks with the values of `initial`, and the priors of the configuration. The flight
  /// and the network must outlive the object.
  CalibrationBlocks(const Flight& flight, const CalibrationState& initial, Network* net);

  /// Return the blocks of the first scanner. They exist, constant, without a scanner, too.
  Block<LeftRotation> boresight() const { return scanners_.front().boresight; }
  Block<Vec<3>> lidar_lever_arm() const { return scanners_.front().lever_arm; }
  Block<Vec<1>> lidar_time_offset() const { return scanners_.front().time_offset; }

  /// Returns the blocks of all scanners in their order, at least one element.
  const std::vector<ScannerBlocks>& scanners() const { return scanners_; }
  Block<Vec<3>> gnss_lever_arm() const { return gnss_lever_arm_; }
  /// Returns the effects in the order of EstimableEffects.
  const std::vector<EffectBlock>& effects() const { return effects_; }

  /// Returns the present values.
  CalibrationState State() const;

  /// Returns the blocks of the effects with these indices.
  std::vector<BlockId> EffectIds(const std::vector<std::size_t>& indices) const;

  /// Returns whether an unknown changes the epochs of the laser.
  bool MovesLidarEpochs() const;

 private:
  void AddGnssLeverArm(const CalibrationState& initial);
  void AddScanner(std::size_t k, const MountingState& initial);
  void AddEffects(const CalibrationState& initial);
  void AddPriors();
  void AddBoresightPrior(std::size_t k);
  void AddBeamPriors();
  bool IsEstimated(const std::string& unknown) const;

  const Flight& flight_;
  Network& net_;
  Block<Vec<3>> gnss_lever_arm_;
  std::vector<ScannerBlocks> scanners_;
  std::vector<EffectBlock> effects_;
};

}  // namespace dn
