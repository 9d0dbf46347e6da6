#include "random_walk.h"

#include <algorithm>
#include <cmath>

namespace dn {

Json DrawRandomWalk(int steps, double step_sigma, Random& random) {
  Json values = Json::array({0.0});
  for (int i = 0; i < steps; ++i) {
    values.push_back(values.back().get<double>() + step_sigma * random.Normal());
  }
  return values;
}

double RandomWalkAt(const std::vector<double>& values, double steps) {
  const double last = static_cast<double>(values.size()) - 2.0;
  const double whole = std::clamp(std::floor(steps), 0.0, last);
  const auto k = static_cast<std::size_t>(whole);
  const double past = std::clamp(steps - whole, 0.0, 1.0);
  return values[k] + past * (values[k + 1] - values[k]);
}

}  // namespace dn
