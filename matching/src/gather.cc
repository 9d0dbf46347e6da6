#include <algorithm>
#include <cmath>

#include "patches.h"
#include "place_points.h"

namespace dn::matching_internal {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2i;
using Eigen::Vector3d;

/// Finds the squares that contain a place, with a grid of cells as large as the largest square.
class SquareIndex {
 public:
  explicit SquareIndex(const std::vector<GatherCell>& squares) : squares_(squares) {
    Vector2d low = squares.front().cell.centre_en_m, high = low;
    for (const GatherCell& square : squares) {
      const Vector2d r = Vector2d::Constant(square.cell.half_m);
      low = low.cwiseMin(square.cell.centre_en_m - r);
      high = high.cwiseMax(square.cell.centre_en_m + r);
      cell_m_ = std::max(cell_m_, square.cell.half_m);
    }
    low_ = low;
    size_ = ((high - low) / cell_m_).array().floor().cast<int>() + 1;
    cells_.resize(static_cast<std::size_t>(size_.x()) * static_cast<std::size_t>(size_.y()));
    for (std::size_t i = 0; i < squares.size(); ++i) {
      const GroundCell& square = squares[i].cell;
      const Vector2d r = Vector2d::Constant(square.half_m);
      const Vector2i from = CellIndex(square.centre_en_m - r),
                     to = CellIndex(square.centre_en_m + r);
      for (int y = from.y(); y <= to.y(); ++y) {
        for (int x = from.x(); x <= to.x(); ++x) {
          if (Has({x, y})) cells_[Index({x, y})].push_back(i);
        }
      }
    }
  }

  template <class Found>
  void ForEachAt(const Vector3d& p_m, const Found& found) const {
    const Vector2i cell = CellIndex(p_m.head<2>());
    if (!Has(cell)) return;
    for (const std::size_t i : cells_[Index(cell)]) {
      if (squares_[i].cell.Contains(p_m)) found(i);
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

  const std::vector<GatherCell>& squares_;
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

CellPoints CellPoints::WithBeam(int number) const {
  CellPoints points;
  for (std::size_t i = 0; i < size(); ++i) {
    if (beam[i] != number) continue;
    points.t_s.push_back(t_s[i]);
    points.x.push_back(x[i]);
    points.p_m.push_back(p_m[i]);
  }
  return points;
}

std::vector<CellPoints> Gather(const MatchSource& source, std::size_t strip,
                               const std::vector<GatherCell>& cells, int threads,
                               const std::function<void(std::uint64_t)>& told) {
  std::vector<CellPoints> gathered(cells.size());
  if (cells.empty()) return gathered;
  const SquareIndex index(cells);
  std::vector<std::uint64_t> seen(cells.size(), 0);
  std::vector<Vector3d> p_m;
  std::uint64_t read = 0;
  source.Read(strip, [&](const RawPoints& points) {
    PlacePoints(source, strip, points.t_s, points.x, threads, &p_m);
    for (std::size_t i = 0; i < points.size(); ++i) {
      index.ForEachAt(p_m[i], [&](std::size_t k) {
        if (Share(seen[k]++) >= cells[k].keep_share) return;
        gathered[k].t_s.push_back(points.t_s[i]);
        gathered[k].x.push_back(points.x[i]);
        gathered[k].p_m.push_back(p_m[i]);
        if (!points.beam.empty()) gathered[k].beam.push_back(points.beam[i]);
      });
    }
    told(read += points.size());
  });
  return gathered;
}

}  // namespace dn::matching_internal
