#include "time_cells.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace dn::diagnosis_internal {
namespace {

constexpr double kShortestGnssCellS = 5.0;
constexpr int kMostGnssCells = 120;
constexpr double kShortestBoresightCellS = 15.0;
constexpr int kMostBoresightCells = 24;

}  // namespace

int TimeCells::At(double t_s) const {
  const auto past = std::upper_bound(start_s.begin(), start_s.end(), t_s);
  return std::max(0, static_cast<int>(past - start_s.begin()) - 1);
}

void TimeCells::Append(double begin_s, double length_s, int count) {
  for (int k = 0; k < count; ++k) start_s.push_back(begin_s + length_s * k);
}

std::vector<StripInterval> InTime(std::vector<StripInterval> strips) {
  std::sort(strips.begin(), strips.end(),
            [](const StripInterval& a, const StripInterval& b) { return a.t0_s < b.t0_s; });
  return strips;
}

double BoresightCellS(const std::vector<StripInterval>& strips) {
  double total_s = 0.0;
  for (const StripInterval& strip : strips) total_s += strip.t1_s - strip.t0_s;
  return std::max(kShortestBoresightCellS, total_s / kMostBoresightCells);
}

TimeCells BoresightCells(const std::vector<StripInterval>& strips) {
  const double length_s = BoresightCellS(strips);
  TimeCells cells;
  for (const StripInterval& strip : strips) {
    const double strip_s = strip.t1_s - strip.t0_s;
    const int count = std::max(1, static_cast<int>(std::lround(strip_s / length_s)));
    cells.Append(strip.t0_s, strip_s / count, count);
  }
  return cells;
}

double GnssCellS(double length_s) {
  return length_s / std::clamp(static_cast<int>(length_s / kShortestGnssCellS), 1, kMostGnssCells);
}

TimeCells GnssCells(double begin_s, double length_s) {
  const double cell_s = GnssCellS(length_s);
  TimeCells cells;
  cells.Append(begin_s, cell_s, static_cast<int>(std::lround(length_s / cell_s)));
  return cells;
}

double Cosines::At(int k, double t_s) const {
  if (k == 0) return 1.0;
  return std::numbers::sqrt2 * std::cos(std::numbers::pi * k * (t_s - begin_s) / length_s);
}

Eigen::VectorXd Cosines::At(double t_s) const {
  Eigen::VectorXd values(count);
  for (int k = 0; k < count; ++k) values[k] = At(k, t_s);
  return values;
}

Eigen::VectorXd Cosines::GaussMarkov(double tau_s) const {
  Eigen::VectorXd sigma(count);
  for (int k = 0; k < count; ++k) {
    const double turned = 2.0 * std::numbers::pi * FrequencyHz(k) * tau_s;
    const double density = 4.0 * tau_s / (1.0 + turned * turned);  // one-sided, per Hz
    const double band_hz = (k == 0 ? 0.25 : 0.5) / length_s;
    sigma[k] = std::sqrt(density * band_hz);
  }
  return sigma;
}

}  // namespace dn::diagnosis_internal
