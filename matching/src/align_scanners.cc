#include <dn/rotation.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "coarse_alignment.h"
#include "line_consensus.h"

namespace dn::matching_internal {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Line = DifferenceLine<Eigen::Dynamic>;

constexpr int kIterations = 5;

/// Linearises pairs in left rotations of the boresights of some scanners.
class PairLines {
 public:
  PairLines(const std::vector<std::size_t>& scanners, const ScannersMatchSource& source)
      : scanners_(scanners), source_(source) {}

  /// Returns whether an end of the pair depends on one of the boresights.
  bool Depends(const CoarsePair& pair) const {
    return Column(pair.strip_i) >= 0 || Column(pair.strip_j) >= 0;
  }

  std::vector<Line> Linearise(const std::vector<CoarsePair>& pairs) const {
    std::vector<Line> lines;
    for (const CoarsePair& pair : pairs) {
      Line line{source_.Position(pair.strip_i, pair.t_i_s, pair.x_i) -
                    source_.Position(pair.strip_j, pair.t_j_s, pair.x_j),
                Eigen::Matrix3Xd::Zero(3, 3 * static_cast<Index>(scanners_.size()))};
      if (const Index i = Column(pair.strip_i); i >= 0) {
        line.A.middleCols<3>(i) += source_.TurnDerivative(pair.strip_i, pair.t_i_s, pair.x_i);
      }
      if (const Index j = Column(pair.strip_j); j >= 0) {
        line.A.middleCols<3>(j) -= source_.TurnDerivative(pair.strip_j, pair.t_j_s, pair.x_j);
      }
      lines.push_back(std::move(line));
    }
    return lines;
  }

 private:
  /// Returns the first column of the boresight of a strip, or -1.
  Index Column(std::size_t strip) const {
    const auto at = std::ranges::find(scanners_, source_.ScannerIndex(strip));
    return at == scanners_.end() ? -1 : 3 * static_cast<Index>(at - scanners_.begin());
  }

  const std::vector<std::size_t>& scanners_;
  const ScannersMatchSource& source_;
};

void Turn(const VectorXd& d, const std::vector<std::size_t>& scanners,
          ScannersMatchSource* source) {
  for (std::size_t k = 0; k < scanners.size(); ++k) {
    FlightMatchSource& own = *source->scanners()[scanners[k]].source;
    const Vector3d turn_rad = d.segment<3>(3 * static_cast<Index>(k));
    own.SetBoresight(Log(Exp(turn_rad) * Exp(own.mounting().boresight_rad)));
  }
}

}  // namespace

AlignmentFit AlignScanners(const std::vector<CoarsePair>& pairs,
                           const std::vector<std::size_t>& scanners, double tolerance_m,
                           const MatchOptions& options, ScannersMatchSource* source) {
  AlignmentFit fit;
  const PairLines all(scanners, *source);
  std::vector<CoarsePair> own;
  std::ranges::copy_if(pairs, std::back_inserter(own),
                       [&](const CoarsePair& pair) { return all.Depends(pair); });
  if (own.size() < kFewestToAlign) return fit;
  const std::vector<std::size_t> which =
      LargestConsensus(all.Linearise(own), tolerance_m, options.search_rad, options.seed);
  fit.agreeing = which.size();
  if (which.size() < kFewestToAlign) return fit;
  std::vector<CoarsePair> agreeing;
  for (const std::size_t k : which) agreeing.push_back(own[k]);
  std::vector<std::size_t> each(agreeing.size());
  std::iota(each.begin(), each.end(), std::size_t{0});
  for (int k = 0; k < kIterations; ++k) {
    Turn(SolveLines(all.Linearise(agreeing), each, kSigmaPerTolerance * tolerance_m,
                    options.search_rad),
         scanners, source);
  }
  double squares_m2 = 0.0;
  for (const Line& line : all.Linearise(agreeing)) squares_m2 += line.w.squaredNorm();
  fit.rms_m = std::sqrt(squares_m2 / static_cast<double>(agreeing.size()));
  return fit;
}

}  // namespace dn::matching_internal
