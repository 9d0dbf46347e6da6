#include <dn/report/document.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

/// Picks the points of an interval that determine its outline.
class Stretch {
 public:
  explicit Stretch(const Curve& curve) : curve_(curve) {}

  void Take(std::size_t k) {
    if (kept_.empty()) kept_ = {k, k, k, k};
    if (curve_.y[k] < curve_.y[kept_[0]]) kept_[0] = k;
    if (curve_.y[k] > curve_.y[kept_[1]]) kept_[1] = k;
    if (curve_.low.empty()) return;
    if (curve_.low[k] < curve_.low[kept_[2]]) kept_[2] = k;
    if (curve_.high[k] > curve_.high[kept_[3]]) kept_[3] = k;
  }

  void MoveTo(std::vector<std::size_t>* all) {
    std::sort(kept_.begin(), kept_.end());
    kept_.erase(std::unique(kept_.begin(), kept_.end()), kept_.end());
    all->insert(all->end(), kept_.begin(), kept_.end());
    kept_.clear();
  }

 private:
  const Curve& curve_;
  std::vector<std::size_t> kept_;
};

std::vector<double> SelectPoints(const std::vector<double>& values,
                                 const std::vector<std::size_t>& kept) {
  std::vector<double> chosen;
  if (values.empty()) return chosen;
  chosen.reserve(kept.size());
  for (const std::size_t k : kept) chosen.push_back(values[k]);
  return chosen;
}

}  // namespace

Curve ThinCurve(const Curve& curve, std::size_t most) {
  const std::size_t count = curve.x.size();
  if (count <= most) return curve;
  const std::size_t per_stretch = curve.low.empty() ? 2 : 4;
  const std::size_t stretches = std::max<std::size_t>(1, most / per_stretch);
  std::vector<std::size_t> kept;
  Stretch stretch(curve);
  for (std::size_t k = 0; k < count; ++k) {
    if (k > 0 && k * stretches / count != (k - 1) * stretches / count) stretch.MoveTo(&kept);
    stretch.Take(k);
  }
  stretch.MoveTo(&kept);
  return {curve.label,
          SelectPoints(curve.x, kept),
          SelectPoints(curve.y, kept),
          SelectPoints(curve.low, kept),
          SelectPoints(curve.high, kept),
          curve.points};
}

}  // namespace dn
