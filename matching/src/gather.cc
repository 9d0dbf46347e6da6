#include <algorithm>
#include <cmath>

#include "patches.h"
#include "place_points.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;

/// Finds the discs that contain a place, with a grid of cells as large as the largest disc.
class DiscIndex {
 public:
  explicit DiscIndex(const std::vector<Disc>& discs) : discs_(discs) {
    Vector2d low = discs.front().centre_en_m, high = low;
    for (const Disc& disc : discs) {
      const Vector2d r = Vector2d::Constant(disc.radius_m);
      low = low.cwiseMin(disc.centre_en_m - r);
      high = high.cwiseMax(disc.centre_en_m + r);
      cell_m_ = std::max(cell_m_, disc.radius_m);
    }
    low_ = low;
    size_ = ((high - low) / cell_m_).array().floor().cast<int>() + 1;
    cells_.resize(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()));
    for (std::size_t i = 0; i < discs.size(); ++i) {
      const Vector2d r = Vector2d::Constant(discs[i].radius_m);
      const Vector2i from = CellIndex(discs[i].centre_en_m - r),
                     to = CellIndex(discs[i].centre_en_m + r);
      for (int y = from.y(); y <= to.y(); ++y) {
        for (int x = from.x(); x <= to.x(); ++x) {
          if (Has({x, y})) cells_[Index({x, y})].push_back(i);
        }
      }
    }
  }

  template <class Found>
  void ForEachAt(const Vector2d& en_m, const Found& found) const {
    const Vector2i cell = CellIndex(en_m);
    if (!Has(cell)) return;
    for (const std::size_t i : cells_[Index(cell)]) {
      const double radius_m = discs_[i].radius_m;
      if ((en_m - discs_[i].centre_en_m).squaredNorm() <= radius_m * radius_m) found(i);
    }
  }

 private:
  Vector2i CellIndex(const Vector2d& en_m) const {
    return ((en_m - low_) / cell_m_).array().floor().cast<int>();
  }
  bool Has(const Vector2i& c) const {
    return c.x() >= 0 && c.y() >= 0 && c.x() < size_.x() && c.y() < size_.y();
  }
  std::size_t Index(const Vector2i& c) const {
    return static_cast<std::size_t>(c.y()) * static_cast<std::size_t>(size_.x()) +
           static_cast<std::size_t>(c.x());
  }

  const std::vector<Disc>& discs_;
  Vector2d low_;
  Vector2i size_;
  double cell_m_ = 0.0;
  std::vector<std::vector<std::size_t>> cells_;
};

/// Returns evenly distributed values in [0, 1): multiples of the golden ratio.
double Share(std::uint64_t i) {
  const double x = 0.6180339887498949 * static_cast<double>(i);
  return x - std::floor(x);
}

}  // namespace

std::vector<DiscPoints> Gather(const MatchSource& source, std::size_t strip,
                               const std::vector<Disc>& discs, int threads,
                               const std::function<void(std::uint64_t)>& told) {
  std::vector<DiscPoints> gathered(discs.size());
  if (discs.empty()) return gathered;
  const DiscIndex index(discs);
  std::vector<std::uint64_t> seen(discs.size(), 0);
  std::vector<Vector3d> p_m;
  std::uint64_t read = 0;
  source.Read(strip, [&](const RawPoints& points) {
    PlacePoints(source, strip, points.t_s, points.x, threads, &p_m);
    for (std::size_t i = 0; i < points.size(); ++i) {
      index.ForEachAt(p_m[i].head<2>(), [&](std::size_t k) {
        if (Share(seen[k]++) >= discs[k].keep_share) return;
        gathered[k].t_s.push_back(points.t_s[i]);
        gathered[k].x.push_back(points.x[i]);
        gathered[k].p_m.push_back(p_m[i]);
      });
    }
    told(read += points.size());
  });
  return gathered;
}

}  // namespace dn::matching_internal
