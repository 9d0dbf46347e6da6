#include "fill_voids.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace dn::matching_internal {
namespace {

constexpr std::size_t kFewestOfHole = 5;
constexpr std::size_t kFewestOfRim = 3;

/// The heights of the neighbours with a height, ascending.
class Neighbours {
 public:
  Neighbours(const std::vector<float>& z_m, int nx, int ny, int x, int y) {
    for (int v = std::max(0, y - 1); v <= std::min(ny - 1, y + 1); ++v) {
      for (int u = std::max(0, x - 1); u <= std::min(nx - 1, x + 1); ++u) {
        const float z = z_m[static_cast<std::size_t>(v) * static_cast<std::size_t>(nx) +
                            static_cast<std::size_t>(u)];
        if (!std::isnan(z)) z_m_[count_++] = z;
      }
    }
    std::sort(z_m_.begin(), z_m_.begin() + static_cast<std::ptrdiff_t>(count_));
  }

  std::size_t count() const { return count_; }
  float lowest() const { return z_m_[0]; }
  float median() const { return z_m_[count_ / 2]; }

 private:
  std::array<float, 9> z_m_{};
  std::size_t count_ = 0;
};

/// Runs one round; returns whether a cell was filled.
template <class Value>
bool FillOnce(int nx, int ny, std::size_t fewest, const Value& value, std::vector<float>* z_m) {
  const std::vector<float> before = *z_m;
  bool filled = false;
  for (int y = 0; y < ny; ++y) {
    for (int x = 0; x < nx; ++x) {
      float& z = (*z_m)[static_cast<std::size_t>(y) * static_cast<std::size_t>(nx) +
                        static_cast<std::size_t>(x)];
      if (!std::isnan(z)) continue;
      const Neighbours neighbours(before, nx, ny, x, y);
      if (neighbours.count() < fewest) continue;
      z = value(neighbours);
      filled = true;
    }
  }
  return filled;
}

}  // namespace

void FillVoids(int nx, int ny, int passes, std::vector<float>* z_m) {
  FillOnce(
      nx, ny, kFewestOfHole, [](const Neighbours& n) { return n.median(); }, z_m);
  const auto lowest = [](const Neighbours& n) { return n.lowest(); };
  for (int pass = 0; pass < passes; ++pass) {
    if (!FillOnce(nx, ny, kFewestOfRim, lowest, z_m)) return;
  }
}

}  // namespace dn::matching_internal
