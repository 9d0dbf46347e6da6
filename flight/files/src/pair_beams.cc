#include "pair_beams.h"

#include <dn/error.h>
#include <dn/files/scanners.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/beam_ends.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace dn::files_internal {
namespace {

constexpr double kLeastToleranceRad = 1.0 / kDegPerRad;
constexpr double kToleranceSigmas = 10.0;

/// The ends of pairs that one scanner with several beams measured.
class ScannerBeams {
 public:
  ScannerBeams(const FlightConfig& config, std::size_t scanner)
      : config_(config),
        scanner_(scanner),
        lidar_(ScannerAt(config, scanner)),
        beams_(*lidar_.beams),
        sums_(beams_.count) {}

  void Check(const PairData& data) {
    const BeamEnds ends = CountBeamEnds(data.pairs, scanner_, beams_.count);
    if (ends.any() && NumMeasuredBeams(ends.of_beam) == 0) FailWithoutBeams();
    for (const LidarPair& pair : data.pairs) {
      Add(data, pair, pair.scanner_i, pair.beam_i, pair.u_i_s);
      Add(data, pair, pair.scanner_j, pair.beam_j, pair.u_j_s);
    }
    for (std::size_t k = 0; k < beams_.angles_rad.size(); ++k) CheckAngle(k);
  }

 private:
  struct Sum {
    double angle_rad = 0.0;
    double ends = 0.0;
  };

  /// Adds an end if this scanner measured it with a known beam.
  void Add(const PairData& data, const LidarPair& pair, int scanner, int beam,
           const Eigen::Vector3d& u_s) {
    if (scanner != static_cast<int>(scanner_) || beam == kNoBeam) return;
    if (beam >= static_cast<int>(beams_.count)) {
      throw InvalidInput("beam " + std::to_string(beam) + " does not exist: " + Key() + " has " +
                             std::to_string(beams_.count) + " beams, numbered from 0",
                         {data.files[static_cast<std::size_t>(pair.file)].string(), pair.line, 0});
    }
    Sum& sum = sums_[static_cast<std::size_t>(beam)];
    sum.angle_rad +=
        std::asin(std::clamp(u_s.normalized().dot(lidar_.scan_axis_s.normalized()), -1.0, 1.0));
    sum.ends += 1.0;
  }

  void CheckAngle(std::size_t k) const {
    if (sums_[k].ends == 0.0) return;
    const double mean_rad = sums_[k].angle_rad / sums_[k].ends;
    const double tolerance_rad =
        std::max(kLeastToleranceRad, kToleranceSigmas * beams_.angle_sigma_rad);
    if (std::abs(mean_rad - beams_.angles_rad[k]) <= tolerance_rad) return;
    throw InvalidConfig("the laser vectors of beam " + std::to_string(k) + " are on average " +
                            Degrees(mean_rad) + " deg toward scan_axis, but " + Key() +
                            ".angles_deg has " + Degrees(beams_.angles_rad[k]) +
                            " deg; check the order of the angles, the beam numbers of the pairs, "
                            "and lidar.scan_axis",
                        Where());
  }

  [[noreturn]] void FailWithoutBeams() const {
    throw InvalidConfig(Key() +
                            " is given, but no pair has a beam: add the columns beam_i and beam_j "
                            "to the pair files, or leave out the key",
                        Where());
  }

  static std::string Degrees(double rad) {
    return FormatDouble(std::round(rad * kDegPerRad * 100.0) / 100.0);
  }
  std::string Key() const {
    return "lidar.beams" + (lidar_.name.empty() ? "" : " of scanner " + lidar_.name);
  }
  FileLocation Where() const { return {config_.file.string(), 0, 0}; }

  const FlightConfig& config_;
  std::size_t scanner_;
  const LidarConfig& lidar_;
  const BeamConfig& beams_;
  std::vector<Sum> sums_;
};

}  // namespace

void CheckPairBeams(const FlightConfig& config, const PairData& data) {
  for (std::size_t k = 0; k < NumScanners(config); ++k) {
    if (ScannerAt(config, k).beams) ScannerBeams(config, k).Check(data);
  }
}

}  // namespace dn::files_internal
