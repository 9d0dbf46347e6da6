#include "scanners_matcher.h"

#include <cmath>

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

/// The points of two scanners that turn may move apart by twice the shift that the angle causes at
/// the mean range. Half of this shift is added for the other angles.
double ScannersMatcher::FirstSearch() const {
  if (loose_.empty()) return 0.0;
  double sum_m = 0.0, count = 0.0;
  for (const StripSample& sample : samples()) {
    for (const Eigen::Vector3f& x : sample.x) sum_m += static_cast<double>(x.norm());
    count += static_cast<double>(sample.size());
  }
  return 2.5 * sum_m / count * std::tan(options().search_rad);
}

AlignmentFit ScannersMatcher::Align(const std::vector<CoarsePair>& pairs, double tolerance_m) {
  return AlignScanners(pairs, loose_, tolerance_m, options(), source_);
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
