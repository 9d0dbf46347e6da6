#include "locations.h"

#include <dn/axis_names.h>
#include <dn/builder/gnss_factors.h>
#include <dn/files/scan_angle.h>
#include <dn/files/strip_at.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>

#include "time_cells.h"

namespace dn::diagnosis_internal {
namespace {

// Smallest redundancy number of a residual that is used.
constexpr double kLeastTermRedundancy = 1e-4;
constexpr int kWindows = 8;
constexpr int kLongLag = 10;
constexpr int kScanAngleBins = 5;
constexpr int kRangeBins = 3;
constexpr std::size_t kFewestTerms = 12;

std::string SensorName(const std::string& channel) {
  if (channel.rfind("gnss", 0) == 0) return "gnss";
  if (channel.rfind("lidar", 0) == 0) return "lidar";
  const bool gyro = channel.find("gyro") != std::string::npos;
  return gyro ? "gyro" : "accel";
}

/// Returns the name of a channel without its sensor: "position".
std::string QuantityName(const std::string& channel) {
  for (const char* sensor : {"gnss ", "lidar "}) {
    if (channel.rfind(sensor, 0) == 0) return channel.substr(std::string(sensor).size());
  }
  return channel;
}

}  // namespace

std::string StatisticName(const LocationStatistic& statistic) {
  const std::string place = statistic.location.empty() ? "" : ", " + statistic.location;
  return statistic.sensor + " " + statistic.quantity + place;
}

/// The residuals of one channel and axis in order of time.
struct Locations::Series {
  std::string sensor, quantity;
  Terms terms;  // pairs of row and time
};

Locations::Locations(const FlightNetwork& network, const LinearizedNetwork& linearized,
                     const Eigen::VectorXd& redundancy)
    : weight_(Eigen::VectorXd::Zero(redundancy.size())) {
  for (Eigen::Index k = 0; k < redundancy.size(); ++k) {
    if (redundancy[k] > kLeastTermRedundancy) weight_[k] = 1.0 / std::sqrt(redundancy[k]);
  }
  std::map<std::string, Series> all;
  for (const LinearizedNetwork::FactorRows& rows : linearized.factors()) {
    const FactorGroup& group = linearized.group(rows.factor);
    const double t_s = linearized.t_s(rows.factor);
    if (!group.measured() || !std::isfinite(t_s)) continue;
    for (int k = 0; k < rows.count; ++k) {
      if (weight_[rows.first + k] == 0.0) continue;
      const std::string channel = group.Channel(k);
      Series& series = all[channel + " " + group.Axis(k)];
      series.sensor = SensorName(channel);
      series.quantity = QuantityName(channel) + " " + group.Axis(k);
      series.terms.emplace_back(rows.first + k, t_s);
    }
  }
  for (auto& [name, series] : all) {
    std::stable_sort(series.terms.begin(), series.terms.end(),
                     [](const auto& a, const auto& b) { return a.second < b.second; });
    AddSeries(series);
  }
  AddPairs(network, linearized);
  for (const GnssEdge& edge : network.gnss().edges()) {
    const auto rows = linearized.FindRows(edge.position);
    if (!rows) continue;
    const Flight& flight = network.flight();
    const Eigen::Vector3d sigma_m =
        GnssPositionCovariance(flight.gnss->epochs[edge.epoch], *flight.config.gnss)
            .diagonal()
            .cwiseSqrt();
    for (int k = 0; k < rows->count && k < 3; ++k) {
      gnss_errors_m_.emplace_back(rows->first + k, sigma_m[k]);
    }
  }
}

void Locations::Add(const LocationStatistic& statistic, Form form, Terms terms) {
  statistics_.push_back(statistic);
  recipes_.push_back({form, std::move(terms), {}});
}

void Locations::AddSeries(const Series& series) {
  if (series.terms.size() < kFewestTerms) return;
  Add({series.sensor, series.quantity + ", mean", ""}, Form::kMean, series.terms);
  Add({series.sensor, series.quantity + ", mean square", ""}, Form::kSquare, series.terms);
  Terms lag = series.terms;
  for (auto& term : lag) term.second = 1.0;
  Add({series.sensor, series.quantity + ", neighbours", ""}, Form::kLag, lag);
  for (auto& term : lag) term.second = kLongLag;
  Add({series.sensor, series.quantity + fmt::format(", {} apart", kLongLag), ""}, Form::kLag, lag);
  AddWindows(series);
  AddBands(series);
}

void Locations::AddWindows(const Series& series) {
  const double begin_s = series.terms.front().second;
  const double length_s = series.terms.back().second - begin_s;
  if (!(length_s > 0.0)) return;
  std::vector<Terms> windows(kWindows);
  for (const auto& term : series.terms) {
    const int k = static_cast<int>(kWindows * (term.second - begin_s) / length_s);
    windows[static_cast<std::size_t>(std::min(k, kWindows - 1))].push_back(term);
  }
  for (int k = 0; k < kWindows; ++k) {
    Terms& window = windows[static_cast<std::size_t>(k)];
    if (window.size() < kFewestTerms) continue;
    const std::string when =
        fmt::format("{:.0f}..{:.0f} s", window.front().second, window.back().second);
    Add({series.sensor, series.quantity + ", mean", when}, Form::kMean, window);
    Add({series.sensor, series.quantity + ", mean square", when}, Form::kSquare, window);
    cells_.push_back(std::move(window));
  }
}

// Adds bands of one octave each, from 1 to 63 half waves of cosines over the series.
void Locations::AddBands(const Series& series) {
  const double length_s = series.terms.back().second - series.terms.front().second;
  if (series.terms.size() < 64 || !(length_s > 0.0)) return;
  const auto n = static_cast<Eigen::Index>(series.terms.size());
  const Eigen::ArrayXd place =
      (Eigen::ArrayXd::LinSpaced(n, 0.0, static_cast<double>(n - 1)) + 0.5) *
      (std::numbers::pi / static_cast<double>(n));
  for (int low = 1; low <= 32; low *= 2) {
    Recipe recipe{Form::kBand, series.terms, Eigen::MatrixXd(n, low)};
    for (int k = 0; k < low; ++k) recipe.cosines.col(k) = ((low + k) * place).cos();
    statistics_.push_back({series.sensor, series.quantity + ", band",
                           fmt::format("{:.2g}..{:.2g} Hz", 0.5 * low / length_s, low / length_s)});
    recipes_.push_back(std::move(recipe));
  }
}

void Locations::AddPairs(const FlightNetwork& network, const LinearizedNetwork& linearized) {
  if (!network.flight().config.lidar) return;
  const LidarConfig& lidar = *network.flight().config.lidar;
  std::map<std::string, std::array<Terms, 3>> groups;
  double most_rad = 1e-3, longest_m = 1.0;
  for (const auto& edge : network.pairs().edges()) {
    most_rad = std::max(most_rad, std::abs(ScanAngle(lidar, edge.pair.u_i_s)));
    longest_m = std::max(longest_m, edge.pair.u_i_s.norm());
  }
  const std::vector<StripInterval> strips = FindStrips(network.flight());
  for (const auto& edge : network.pairs().edges()) {
    const auto rows = linearized.FindRows(edge.id);
    if (!rows || rows->count != 3) continue;
    const int bin =
        std::clamp(static_cast<int>((ScanAngle(lidar, edge.pair.u_i_s) / most_rad + 1.0) * 0.5 *
                                    kScanAngleBins),
                   0, kScanAngleBins - 1);
    const int range = std::clamp(static_cast<int>(edge.pair.u_i_s.norm() / longest_m * kRangeBins),
                                 0, kRangeBins - 1);
    const double width_deg = 2.0 * most_rad * 180.0 / std::numbers::pi / kScanAngleBins;
    const double low_deg = -most_rad * 180.0 / std::numbers::pi + width_deg * bin;
    const std::string strips_of =
        "strips " + StripPairName(strips, edge.pair.t_i_s, edge.pair.t_j_s);
    const std::string names[] = {
        strips_of,
        strips_of + fmt::format(", scan angle {:.0f}..{:.0f} deg", low_deg, low_deg + width_deg),
        fmt::format("range {:.0f}..{:.0f} m", longest_m * range / kRangeBins,
                    longest_m * (range + 1) / kRangeBins)};
    for (int axis = 0; axis < 3; ++axis) {
      const Eigen::Index row = rows->first + axis;
      pair_errors_m_.emplace_back(row, lidar.sigma_p_m);
      if (weight_[row] == 0.0) continue;
      for (const std::string& name : names) {
        groups[name][static_cast<std::size_t>(axis)].emplace_back(row, edge.pair.t_i_s);
      }
    }
  }
  for (auto& [name, of_axes] : groups) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (of_axes[axis].size() < kFewestTerms) continue;
      const std::string quantity = std::string("p2p ") + kEnu[axis];
      Add({"lidar", quantity + ", mean", name}, Form::kMean, of_axes[axis]);
      Add({"lidar", quantity + ", mean square", name}, Form::kSquare, of_axes[axis]);
    }
  }
}

double Locations::EvaluateRecipe(const Recipe& recipe, const Eigen::VectorXd& r) const {
  const Terms& terms = recipe.terms;
  const auto w = [&](std::size_t k) { return weight_[terms[k].first] * r[terms[k].first]; };
  const auto n = static_cast<double>(terms.size());
  double sum = 0.0;
  switch (recipe.form) {
    case Form::kMean:
      for (std::size_t k = 0; k < terms.size(); ++k) sum += w(k);
      return sum / std::sqrt(n);
    case Form::kSquare:
      for (std::size_t k = 0; k < terms.size(); ++k) sum += w(k) * w(k);
      return std::log(std::max(sum / n, 1e-12));
    case Form::kLag: {
      const auto lag = static_cast<std::size_t>(terms.front().second);
      for (std::size_t k = lag; k < terms.size(); ++k) sum += w(k) * w(k - lag);
      return sum / n;
    }
    case Form::kBand: {
      Eigen::VectorXd values(recipe.cosines.rows());
      for (std::size_t k = 0; k < terms.size(); ++k) values[static_cast<Eigen::Index>(k)] = w(k);
      sum = 2.0 * (recipe.cosines.transpose() * values).squaredNorm() / n;
      return std::log(std::max(sum, 1e-12));
    }
  }
  return sum;
}

Eigen::VectorXd Locations::Evaluate(const Eigen::VectorXd& r) const {
  Eigen::VectorXd values(static_cast<Eigen::Index>(recipes_.size()));
  for (std::size_t k = 0; k < recipes_.size(); ++k) {
    values[static_cast<Eigen::Index>(k)] = EvaluateRecipe(recipes_[k], r);
  }
  return values;
}

double Locations::SizeNats(const Eigen::VectorXd& r) const {
  double nats = 0.0, count = 0.0;
  for (const Terms& cell : cells_) {
    const auto n = static_cast<double>(cell.size());
    double mean = 0.0, square = 0.0, product = 0.0, before = 0.0;
    for (const auto& [row, t_s] : cell) mean += weight_[row] * r[row] / n;
    for (const auto& [row, t_s] : cell) {
      const double off = weight_[row] * r[row] - mean;
      square += off * off / n;
      product += off * before / n;
      before = off;
    }
    const double variance = std::max(square, 1e-12);
    const double correlation = std::clamp(product / variance, -0.999, 0.999);
    nats += n * (0.5 * (variance + mean * mean - 1.0 - std::log(variance)) -
                 0.5 * std::log(1.0 - correlation * correlation));
    count += n;
  }
  return count > 0.0 ? nats / count : 0.0;
}

// A residual divided by its redundancy number is the error of its prediction from all other data.
double Locations::Rms(const Terms& terms, const Eigen::VectorXd& r) const {
  double sum = 0.0, count = 0.0;
  for (const auto& [row, sigma_m] : terms) {
    const double error_m = sigma_m * weight_[row] * weight_[row] * r[row];
    sum += error_m * error_m;
    count += weight_[row] > 0.0 ? 1.0 : 0.0;
  }
  return count > 0.0 ? std::sqrt(sum / count) : 0.0;
}

double Locations::PairRms(const Eigen::VectorXd& r) const { return Rms(pair_errors_m_, r); }
double Locations::GnssRms(const Eigen::VectorXd& r) const { return Rms(gnss_errors_m_, r); }

}  // namespace dn::diagnosis_internal
