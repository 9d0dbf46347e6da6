#include "pair_library.h"

#include <dn/files/scan_angle.h>
#include <dn/files/strip_at.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "discrepancies.h"

namespace dn::diagnosis_internal {
namespace {

constexpr int kScanAnglePlaces = 8;
constexpr std::size_t kFewestPairsOfPlace = 5;

class PairLibraryMaker {
 public:
  PairLibraryMaker(const Flight& flight, const LinearPairs& pairs,
                   const std::vector<StripInterval>& strips, const LibraryOptions& options)
      : flight_(flight),
        lidar_(*flight.config.lidar),
        pairs_(pairs),
        strips_(InTime(strips)),
        options_(options),
        scan_angles_(FindScanAngleRange(lidar_, pairs.ends)) {}

  PairLibrary Run() {
    Library scanner = MakeScannerHypotheses(flight_, pairs_.ends);
    for (std::size_t k = 0; k < scanner.hypotheses.size(); ++k) {
      AddFixed(std::move(scanner.hypotheses[k]), std::move(scanner.blocks[k]));
    }
    const Hypothesis drift = MakeHypothesis(*FindEstimable(EffectId::kBoresightDrift), {flight_});
    AddFixed(drift, MakePairColumns(drift, pairs_.ends));
    AddBoresightShapes();
    AddGeneric(LaserByScanAngle(lidar_, scan_angles_));
    if (strips_.size() > 1 && strips_.size() <= kMaxJointStrips) {
      AddGeneric(LaserByStrip(strips_));
    }
    AddStripPlaces();
    AddScanAnglePlaces();
    std::swap(out_.blocks, out_.library.blocks);
    return std::move(out_);
  }

 private:
  void AddFixed(Hypothesis effect, EffectModel columns) {
    if (options_.Wanted(effect.name)) out_.library.Add(std::move(effect), std::move(columns));
  }

  void AddGeneric(const Hypothesis& discrepancy) {
    out_.library.Add(discrepancy, MakePairColumns(discrepancy, pairs_.ends));
  }

  void AddBoresightShapes() {
    if (strips_.size() <= kMaxJointStrips) {
      const TimeCells cells = BoresightCells(strips_);
      const Hypothesis by_cell = BoresightByCell(cells);
      AddBoresightTimes(by_cell, MakePairColumns(by_cell, pairs_.ends), cells, options_,
                        &out_.library);
    }
    const std::vector<double> taus_s = SettlingTausS(strips_);
    if (taus_s.empty()) return;
    const Hypothesis settling = BoresightSettling(strips_.front().t0_s, taus_s);
    AddSettling(settling, MakePairColumns(settling, pairs_.ends), taus_s, &out_.library);
    if (strips_.size() < kFewestHeadings) return;
    AddGeneric(BoresightByHeading(strips_, flight_.trajectory->ToMapPoses(flight_.frame)));
  }

  /// Adds a common offset of some pairs.
  void AddPlace(const std::string& location, const std::vector<std::size_t>& members) {
    if (members.size() < kFewestPairsOfPlace) return;
    EffectModel columns;
    for (const PairEnds& pair : pairs_.ends) {
      columns.push_back({pair.factor, Eigen::Matrix3d::Zero()});
    }
    for (const std::size_t k : members) columns[k].L = pairs_.whiten[k];
    out_.places.push_back({location, out_.library.AddBlock(std::move(columns))});
  }

  void AddStripPlaces() {
    std::map<std::string, std::vector<std::size_t>> members;
    for (std::size_t k = 0; k < pairs_.ends.size(); ++k) {
      const PairEnds& pair = pairs_.ends[k];
      members[StripPairName(strips_, pair.i.t_s, pair.j.t_s)].push_back(k);
    }
    if (members.size() > kMaxJointStrips) return;
    for (const auto& [strips, of_strips] : members) AddPlace("strips " + strips, of_strips);
  }

  void AddScanAnglePlaces() {
    std::vector<std::vector<std::size_t>> members(kScanAnglePlaces);
    const auto& [low_rad, high_rad] = scan_angles_;
    const double step_rad = (high_rad - low_rad) / kScanAnglePlaces;
    for (std::size_t k = 0; k < pairs_.ends.size(); ++k) {
      const double at = (ScanAngle(lidar_, pairs_.ends[k].i.u_s) - low_rad) / step_rad;
      members[static_cast<std::size_t>(std::clamp(at, 0.0, kScanAnglePlaces - 0.5))].push_back(k);
    }
    for (int k = 0; k < kScanAnglePlaces; ++k) {
      const double low_deg = (low_rad + step_rad * k) * kDegPerRad;
      AddPlace(
          fmt::format("scan angle {:.0f}..{:.0f} deg", low_deg, low_deg + step_rad * kDegPerRad),
          members[static_cast<std::size_t>(k)]);
    }
  }

  const Flight& flight_;
  const LidarConfig& lidar_;
  const LinearPairs& pairs_;
  std::vector<StripInterval> strips_;
  const LibraryOptions& options_;
  ScanAngleRange scan_angles_;
  PairLibrary out_;
};

}  // namespace

PairLibrary MakeLibrary(const Flight& flight, const LinearPairs& pairs,
                        const std::vector<StripInterval>& strips, const LibraryOptions& options) {
  return PairLibraryMaker(flight, pairs, strips, options).Run();
}

}  // namespace dn::diagnosis_internal
