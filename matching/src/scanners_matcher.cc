#include "scanners_matcher.h"

#include "coarse_alignment.h"

namespace dn::matching_internal {

using Eigen::Vector3d;

ScannersMatcher::ScannersMatcher(ScannersMatchSource* source, const MatchOptions& options)
    : Matcher(source, options), source_(*source) {
  for (std::size_t k = 0; k < source_.scanners().size(); ++k) {
    if (source_.scanners()[k].aligned) continue;
    loose_.push_back(k);
    given_rad_.push_back(Scanner(k).mounting().boresight_rad);
  }
}

AlignmentFit ScannersMatcher::Align(const std::vector<CoarsePair>& pairs, double tolerance_m) {
  return AlignScanners(pairs, loose_, tolerance_m, options(), &source_);
}

Vector3d ScannersMatcher::Boresight() const {
  return loose_.empty() ? Vector3d(Vector3d::Zero())
                        : Scanner(loose_.front()).mounting().boresight_rad;
}

void ScannersMatcher::AsGiven(const std::function<void()>& work) {
  std::vector<Vector3d> found_rad;
  for (std::size_t i = 0; i < loose_.size(); ++i) {
    found_rad.push_back(Scanner(loose_[i]).mounting().boresight_rad);
    Scanner(loose_[i]).SetBoresight(given_rad_[i]);
  }
  work();
  for (std::size_t i = 0; i < loose_.size(); ++i) Scanner(loose_[i]).SetBoresight(found_rad[i]);
}

bool ScannersMatcher::Compares(std::size_t i, std::size_t j) const {
  return source_.ScannerIndex(i) != source_.ScannerIndex(j);
}

}  // namespace dn::matching_internal
