#include <dn/blind_check/blind_score.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace dn {

double Share::value() const {
  if (of == 0) return std::numeric_limits<double>::quiet_NaN();
  return static_cast<double>(hits) / static_cast<double>(of);
}

// Source: E. B. Wilson, Probable inference, the law of succession, and statistical inference, 1927.
Interval Share::interval_95() const {
  if (of == 0) return {0.0, 1.0};
  const double z2 = std::pow(NormalQuantile(0.975), 2);
  const auto n = static_cast<double>(of);
  const double p = value();
  const double centre = (p + z2 / (2.0 * n)) / (1.0 + z2 / n);
  const double half = std::sqrt(z2 * (p * (1.0 - p) / n + z2 / (4.0 * n * n))) / (1.0 + z2 / n);
  return {hits == 0 ? 0.0 : centre - half, hits == of ? 1.0 : centre + half};
}

}  // namespace dn
