#include <dn/geo/median_step.h>
#include <dn/median.h>

#include <utility>

namespace dn {

double MedianStep(const std::vector<NavPoint>& points) {
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < points.size(); ++i) {
    steps_s.push_back(points[i].t_s - points[i - 1].t_s);
  }
  return Median(std::move(steps_s));
}

}  // namespace dn
