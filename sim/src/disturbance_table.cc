#include "disturbance_table.h"

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

constexpr double kNodeSpacing_s = 1.0 / 16.0;

struct HermiteWeights {
  Eigen::Vector3d value, first, second;
};

/// Returns the weights of the node before x, which is in [0, 1]: the quintic that is 0 at 1 with
/// its derivatives.
HermiteWeights Before(double x) {
  const double y = 1.0 - x, y2 = y * y, x2 = x * x;
  HermiteWeights w;
  w.value << y2 * y * (1.0 + 3.0 * x + 6.0 * x2), y2 * y * x * (1.0 + 3.0 * x), 0.5 * y2 * y * x2;
  w.first << -30.0 * x2 * y2, y2 * (1.0 + 2.0 * x - 15.0 * x2), 0.5 * y2 * x * (2.0 - 5.0 * x);
  w.second << -60.0 * x * y * (y - x), y * x * (60.0 * x - 36.0), y * (1.0 - 8.0 * x + 10.0 * x2);
  return w;
}

/// Returns the weights of the node after x, by symmetry.
HermiteWeights After(double x) {
  HermiteWeights w = Before(1.0 - x);
  w.value[1] = -w.value[1];
  w.first[0] = -w.first[0];
  w.first[2] = -w.first[2];
  w.second[1] = -w.second[1];
  return w;
}

}  // namespace

DisturbanceTable::DisturbanceTable(const Disturbance& disturbance, double duration_s) {
  const SumOfSines* const sums[] = {&disturbance.lead_s, &disturbance.height_m,
                                    &disturbance.roll_rad, &disturbance.pitch_rad,
                                    &disturbance.heading_rad};
  const auto last = static_cast<long>(std::ceil(duration_s / kNodeSpacing_s)) + 1;
  for (long k = -1; k <= last; ++k) {
    Node node;
    for (int channel = 0; channel < 5; ++channel) {
      const SumOfSines::Sample at = sums[channel]->At(static_cast<double>(k) * kNodeSpacing_s);
      node.row(channel) << at.value, kNodeSpacing_s * at.first,
          kNodeSpacing_s * kNodeSpacing_s * at.second;
    }
    nodes_.push_back(node);
  }
}

DisturbanceTable::Sample DisturbanceTable::At(double t_s) const {
  const double steps = t_s / kNodeSpacing_s + 1.0;
  const double last = static_cast<double>(nodes_.size()) - 2.0;
  const double node = std::clamp(std::floor(steps), 0.0, last);
  const double x = steps - node;
  const Node& n0 = nodes_[static_cast<std::size_t>(node)];
  const Node& n1 = nodes_[static_cast<std::size_t>(node) + 1];
  const HermiteWeights w0 = Before(x), w1 = After(x);
  return {n0 * w0.value + n1 * w1.value, (n0 * w0.first + n1 * w1.first) / kNodeSpacing_s,
          (n0 * w0.second + n1 * w1.second) / (kNodeSpacing_s * kNodeSpacing_s)};
}

}  // namespace dn
