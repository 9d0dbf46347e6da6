#include <cmath>

#include "coarse_alignment.h"
#include "median_by_axis.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector3d;

/// Returns the shift with which most differences agree: the median, per axis, of the differences
/// near the one that has the most others near it.
Vector3d Consensus(const std::vector<Vector3d>& differences_m, double tolerance_m) {
  std::vector<Vector3d> best;
  for (const Vector3d& centre_m : differences_m) {
    std::vector<Vector3d> near;
    for (const Vector3d& d_m : differences_m) {
      if ((d_m - centre_m).norm() < tolerance_m) near.push_back(d_m);
    }
    if (near.size() > best.size()) best = std::move(near);
  }
  return MedianByAxis(best);
}

}  // namespace

AlignmentFit AlignShifts(const std::vector<CoarsePair>& pairs, double tolerance_m,
                         BareMatchSource* source) {
  AlignmentFit fit;
  double squares = 0.0;
  // Each strip is shifted to the first earlier strip with which it has pairs.
  std::vector<Vector3d> moved(source->strips().size(), Vector3d::Zero());
  for (std::size_t j = 1; j < source->strips().size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      std::vector<Vector3d> differences_m;
      for (const CoarsePair& pair : pairs) {
        if (pair.strip_i == i && pair.strip_j == j) differences_m.push_back(pair.difference_m);
      }
      if (differences_m.empty()) continue;
      const Vector3d shift_m = Consensus(differences_m, tolerance_m);
      for (const Vector3d& d_m : differences_m) {
        const double left_m = (d_m - shift_m).norm();
        if (left_m >= tolerance_m) continue;
        ++fit.agreeing;
        squares += left_m * left_m;
      }
      moved[j] = moved[i] + shift_m;
      source->SetShift(j, source->shift_m(j) + moved[j]);
      break;
    }
  }
  if (fit.agreeing > 0) fit.rms_m = std::sqrt(squares / static_cast<double>(fit.agreeing));
  return fit;
}

}  // namespace dn::matching_internal
