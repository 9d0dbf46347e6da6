#include "patch_surface.h"

#include <numeric>
#include <utility>

#include "local_planes.h"

namespace dn::matching_internal {

PatchSurface::PatchSurface(std::vector<Eigen::Vector3d> points_m, double radius_m)
    : points_m_(std::move(points_m)), tree_(points_m_) {
  std::vector<std::size_t> all(points_m_.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  planes_ = FitLocalPlanes(points_m_, tree_, all, radius_m);
}

}  // namespace dn::matching_internal
