#include "pair_library.h"

#include <dn/effects/effect_table.h>
#include <dn/files/scan_angle.h>
#include <dn/files/strip_at.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "candidate_effects.h"
#include "generic_effects.h"
#include "laser_discrepancies.h"

namespace dn::internal {
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
    for (CandidateEffect& effect : MakeScannerEffects(flight_, pairs_.ends))
      AddFixed(std::move(effect));
    AddFixed(MakePairCandidate(*FindEstimable(EffectId::kBoresightDrift), flight_, pairs_.ends));
    AddBoresightByCell();
    AddBoresightShapes();
    AddGeneric(LaserByScanAngle(lidar_, scan_angles_));
    if (strips_.size() > 1 && strips_.size() <= kMaxJointStrips) {
      AddGeneric(LaserByStrip(strips_));
    }
    AddStripPlaces();
    AddScanAnglePlaces();
    return std::move(out_);
  }

 private:
  std::size_t AddBlock(CandidateEffect block) {
    out_.blocks.push_back(std::move(block));
    return out_.blocks.size() - 1;
  }

  static Candidate Describe(const CandidateEffect& effect, std::size_t block) {
    Candidate candidate;
    candidate.name = effect.name;
    candidate.id = FindEffect(effect.name)->id;
    candidate.times = effect.times;
    candidate.block = block;
    candidate.typical = effect.typical;
    candidate.unit = effect.unit;
    candidate.per_si = effect.per_si;
    return candidate;
  }

  void AddFixed(CandidateEffect effect) {
    if (!options_.Wanted(effect.name)) return;
    Candidate candidate = Describe(effect, 0);
    candidate.block = AddBlock(std::move(effect));
    out_.library.candidates.push_back(std::move(candidate));
  }

  std::size_t AddOwn(const UserEffect& own) {
    return AddBlock(MakePairCandidate(own, pairs_.ends));
  }

  void AddGeneric(const UserEffect& own) { AddGeneric(own, AddOwn(own)); }

  void AddGeneric(const UserEffect& own, std::size_t block) {
    out_.library.candidates.push_back(MakeDiscrepancy(own.name, block, own.typical));
  }

  void AddBoresightByCell() {
    if (strips_.size() > kMaxJointStrips) return;
    const TimeCells cells = BoresightCells(strips_);
    const UserEffect own = BoresightByCell(cells);
    const std::size_t block = AddOwn(own);
    if (options_.Wanted(EffectId::kBoresightStep)) {
      for (int cell = 1; cell < cells.count(); ++cell) {
        Candidate step = Describe(DescribeEffect(*FindEstimable(EffectId::kBoresightStep)), block);
        step.cells = CellRange{cell, cells.count()};
        step.times.t0_s = cells.start_s[static_cast<std::size_t>(cell)];
        out_.library.candidates.push_back(std::move(step));
      }
    }
    AddGeneric(own, block);
  }

  void AddBoresightShapes() {
    const std::vector<double> taus_s = SettlingTausS(strips_);
    if (taus_s.empty()) return;
    const UserEffect settling = BoresightSettling(strips_.front().t0_s, taus_s);
    AddSettling(settling.name, AddOwn(settling), taus_s, settling.typical, &out_.library);
    if (strips_.size() < kFewestHeadings) return;
    AddGeneric(BoresightByHeading(strips_, flight_.trajectory->ToMapPoses(flight_.frame)));
  }

  /// Adds a common offset of some pairs.
  void AddPlace(const std::string& location, const std::vector<std::size_t>& members) {
    if (members.size() < kFewestPairsOfPlace) return;
    CandidateEffect block;
    block.name = location;
    block.typical = Eigen::Vector3d::Constant(lidar_.sigma_p_m);
    for (const PairEnds& pair : pairs_.ends)
      block.model.push_back({pair.factor, Eigen::Matrix3d::Zero()});
    for (const std::size_t k : members) block.model[k].L = pairs_.whiten[k];
    out_.places.push_back({location, AddBlock(std::move(block))});
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

}  // namespace dn::internal
