#pragma once

#include <Eigen/Core>

namespace dn {

/// Returns the height of small waves on water above its mean level, m (rms 0.03 m). They run with
/// the speed of waves on deep water, so that strips flown at different times see other heights.
double WaveHeight(const Eigen::Vector2d& en_m, double t_s);

}  // namespace dn
