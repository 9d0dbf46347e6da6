#include <dn/files/file_units.h>
#include <dn/geo/text_table.h>

#include <cmath>
#include <limits>

namespace dn {
namespace {

constexpr int kNeighbours = 4;  // after two roundings the exact inverse lies within two ulp

double Step(double value, int ulps) {
  const double toward =
      ulps > 0 ? std::numeric_limits<double>::infinity() : -std::numeric_limits<double>::infinity();
  for (int i = 0; i < std::abs(ulps); ++i) value = std::nextafter(value, toward);
  return value;
}

}  // namespace

double RadFromDeg(double deg) { return deg * 3.14159265358979323846 / 180.0; }

double InUnit(double si, ToSi to_si) {
  const double guess = si / to_si(1.0);
  double best = guess;
  std::size_t best_length = std::numeric_limits<std::size_t>::max();
  for (int ulps = -kNeighbours; ulps <= kNeighbours; ++ulps) {
    const double candidate = Step(guess, ulps);
    if (to_si(candidate) != si) continue;
    const std::size_t length = FormatDouble(candidate).size();
    if (length < best_length) {
      best = candidate;
      best_length = length;
    }
  }
  return best;
}

}  // namespace dn
