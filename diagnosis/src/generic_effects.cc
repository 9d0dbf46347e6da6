#include "generic_effects.h"

#include <dn/factors/gnss_antenna.h>
#include <dn/factors/lidar_effect.h>
#include <dn/geo/nearest_pose.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <utility>

namespace dn::internal {
namespace {

// Typical sizes of unmodelled discrepancies.
constexpr double kBoresightRad = 5e-5;
constexpr double kGnssM = 0.02;

constexpr double kShortestGnssCellS = 5.0;
constexpr int kMostGnssCells = 120;
constexpr double kShortestBoresightCellS = 15.0;
constexpr int kMostBoresightCells = 24;

constexpr double kSettlingOfStrips[] = {1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0};

/// Sets the weights of the values, which are three-vectors, at the time t_s. The correction is the
/// weighted sum of the values.
using Weights = std::function<void(double t_s, Eigen::VectorXd* weights)>;

class TurnByTime final : public LidarEffect {
 public:
  TurnByTime(int count, Weights weights) : count_(count), weights_(std::move(weights)) {}
  int components() const override { return 3 * count_; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               LidarReading* reading) const override {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(count_);
    weights_(reading->tag_s - reading->delay_s, &w);
    for (int k = 0; k < count_; ++k) {
      if (w[k] == 0.0) continue;
      reading->turn_b_rad += w[k] * value.segment<3>(3 * k);
      reading->J_turn.middleCols<3>(column + 3 * k) = w[k] * Eigen::Matrix3d::Identity();
    }
  }

 private:
  int count_;
  Weights weights_;
};

class ShiftByTime final : public GnssEffect {
 public:
  ShiftByTime(int count, Weights weights) : count_(count), weights_(std::move(weights)) {}
  int components() const override { return 3 * count_; }
  void Correct(const Eigen::Ref<const Eigen::VectorXd>& value, Eigen::Index column,
               GnssReading* reading) const override {
    Eigen::VectorXd w = Eigen::VectorXd::Zero(count_);
    weights_(reading->tag_s - reading->delay_s, &w);
    for (int k = 0; k < count_; ++k) {
      if (w[k] == 0.0) continue;
      reading->shift_m += w[k] * value.segment<3>(3 * k);
      reading->J_shift.middleCols<3>(column + 3 * k) = w[k] * Eigen::Matrix3d::Identity();
    }
  }

 private:
  int count_;
  Weights weights_;
};

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

UserEffect BoresightByCell(const TimeCells& cells) {
  auto weights = [cells](double t_s, Eigen::VectorXd* w) { (*w)[cells.At(t_s)] = 1.0; };
  return {"boresight by time", std::make_shared<TurnByTime>(cells.count(), std::move(weights)),
          Eigen::VectorXd::Constant(3 * cells.count(), kBoresightRad)};
}

std::vector<double> SettlingTausS(const std::vector<StripInterval>& strips) {
  std::vector<double> taus_s;
  if (strips.empty()) return taus_s;
  const double length_s = strips.back().t1_s - strips.front().t0_s;
  for (const double fraction : kSettlingOfStrips) taus_s.push_back(fraction * length_s);
  return taus_s;
}

UserEffect BoresightSettling(double begin_s, const std::vector<double>& taus_s) {
  auto weights = [begin_s, taus_s](double t_s, Eigen::VectorXd* w) {
    for (std::size_t k = 0; k < taus_s.size(); ++k) {
      (*w)[static_cast<Eigen::Index>(k)] = std::exp(-(t_s - begin_s) / taus_s[k]);
    }
  };
  const auto count = static_cast<int>(taus_s.size());
  return {"boresight that settles", std::make_shared<TurnByTime>(count, std::move(weights)),
          Eigen::VectorXd::Constant(3 * count, kBoresightRad)};
}

UserEffect BoresightByHeading(const std::vector<StripInterval>& strips,
                              const std::vector<MapPose>& path) {
  TimeCells of_strips;
  std::vector<Eigen::Vector2d> course;
  for (const StripInterval& strip : strips) {
    const MapPose middle = NearestPose(path, 0.5 * (strip.t0_s + strip.t1_s));
    const Eigen::Vector3d forward = middle.q_mb * Eigen::Vector3d::UnitX();
    of_strips.start_s.push_back(strip.t0_s);
    course.emplace_back(forward.head<2>().normalized());
  }
  auto weights = [of_strips, course](double t_s, Eigen::VectorXd* w) {
    *w = course[static_cast<std::size_t>(of_strips.At(t_s))];
  };
  return {"boresight by heading", std::make_shared<TurnByTime>(2, std::move(weights)),
          Eigen::VectorXd::Constant(6, kBoresightRad)};
}

UserEffect GnssByCell(const TimeCells& cells) {
  auto weights = [cells](double t_s, Eigen::VectorXd* w) { (*w)[cells.At(t_s)] = 1.0; };
  return {"GNSS positions by time",
          std::make_shared<ShiftByTime>(cells.count(), std::move(weights)),
          Eigen::VectorXd::Constant(3 * cells.count(), kGnssM)};
}

UserEffect GnssByCosine(const Cosines& cosines) {
  auto weights = [cosines](double t_s, Eigen::VectorXd* w) { *w = cosines.At(t_s); };
  return {"GNSS positions by frequency",
          std::make_shared<ShiftByTime>(cosines.count, std::move(weights)),
          Eigen::VectorXd::Constant(3 * cosines.count, kGnssM)};
}

}  // namespace dn::internal
