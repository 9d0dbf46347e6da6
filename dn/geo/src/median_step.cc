#include <dn/geo/median_step.h>

#include <algorithm>

namespace dn {

double MedianStep(const std::vector<NavPoint>& points) {
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < points.size(); ++i) {
    steps_s.push_back(points[i].t_s - points[i - 1].t_s);
  }
  const auto middle = steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2);
  std::nth_element(steps_s.begin(), middle, steps_s.end());
  return *middle;
}

}  // namespace dn
