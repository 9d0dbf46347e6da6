#include "time_nodes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace dn::fixed_trajectory_internal {
namespace {

constexpr double kPause_s = 5.0;
constexpr double kShortestSpacing_s = 1.0;
constexpr int kSamplesPerNode = 6;

std::ptrdiff_t StripIndex(double t_s, const std::vector<double>& strip_begin_s) {
  return std::upper_bound(strip_begin_s.begin(), strip_begin_s.end(), t_s) - strip_begin_s.begin();
}

}  // namespace

TimeNodes::TimeNodes(std::vector<double> epochs_s, const std::vector<double>& strip_begin_s,
                     int max_nodes) {
  std::sort(epochs_s.begin(), epochs_s.end());
  constexpr double kGrowth = 1.1;
  for (double spacing_s = kShortestSpacing_s;
       Divide(epochs_s, strip_begin_s, spacing_s) > max_nodes;) {
    spacing_s *= kGrowth;
  }
  Sample();
}

int TimeNodes::Divide(const std::vector<double>& epochs_s, const std::vector<double>& strip_begin_s,
                      double spacing_s) {
  strips_.clear();
  for (const double t_s : epochs_s) {
    const double pause_s = strips_.empty() ? 0.0 : t_s - strips_.back().end_s;
    const bool parted =
        strips_.empty() || strip_begin_s.empty()
            ? pause_s > kPause_s
            : StripIndex(t_s, strip_begin_s) != StripIndex(strips_.back().end_s, strip_begin_s);
    if (strips_.empty() || (parted && pause_s > spacing_s)) strips_.push_back({t_s, t_s, 0, 1});
    strips_.back().end_s = t_s;
  }
  t_s_.clear();
  for (Strip& strip : strips_) {
    strip.first = size();
    strip.count = 1 + static_cast<int>(std::lround((strip.end_s - strip.begin_s) / spacing_s));
    const double step_s = (strip.end_s - strip.begin_s) / std::max(1, strip.count - 1);
    for (int k = 0; k < strip.count; ++k) t_s_.push_back(strip.begin_s + k * step_s);
  }
  return size();
}

TimeNodes::TimeNodes(const std::vector<double>& t_s, const std::vector<int>& strip) : t_s_(t_s) {
  for (std::size_t k = 0; k < t_s.size(); ++k) {
    if (k == 0 || strip[k] != strip[k - 1]) {
      strips_.push_back({t_s[k], t_s[k], static_cast<int>(k), 0});
    }
    strips_.back().end_s = t_s[k];
    ++strips_.back().count;
  }
}

TimeNodes::Place TimeNodes::At(double t_s) const {
  const auto next = std::upper_bound(strips_.begin(), strips_.end(), t_s,
                                     [](double t, const Strip& s) { return t < s.begin_s; });
  const Strip& strip = next == strips_.begin() ? strips_.front() : *(next - 1);
  if (strip.count == 1) return {strip.first, strip.first, 0.0};
  const auto first = t_s_.begin() + strip.first;
  const auto after = std::upper_bound(first + 1, first + strip.count - 1, t_s);
  const double a_s = *(after - 1), b_s = *after;
  const int next_node = static_cast<int>(after - t_s_.begin());
  return {next_node - 1, next_node, std::clamp((t_s - a_s) / (b_s - a_s), 0.0, 1.0)};
}

void TimeNodes::Sample() {
  for (std::size_t s = 0; s < strips_.size(); ++s) {
    const Strip& strip = strips_[s];
    const int n = kSamplesPerNode * strip.count;
    for (int k = 0; k < n; ++k) {
      sample_t_s_.push_back(strip.begin_s + (k + 0.5) / n * (strip.end_s - strip.begin_s));
      sample_strip_.push_back(static_cast<int>(s));
    }
  }
  Eigen::MatrixXd F = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(sample_t_s_.size()), size());
  for (Eigen::Index k = 0; k < F.rows(); ++k) {
    const Place place = At(sample_t_s_[static_cast<std::size_t>(k)]);
    F(k, place.node) += 1.0 - place.next;
    F(k, place.next_node) += place.next;
  }
  from_samples_ = (F.transpose() * F).llt().solve(F.transpose());
}

Eigen::MatrixXd TimeNodes::Covariance(const ErrorProcess& process) const {
  const Eigen::Index n = from_samples_.cols();
  Eigen::MatrixXd K(n, n);
  for (std::size_t k = 0; k < sample_t_s_.size(); ++k) {
    for (std::size_t l = 0; l <= k; ++l) {
      const double apart_s = std::abs(sample_t_s_[k] - sample_t_s_[l]);
      const auto row = static_cast<Eigen::Index>(k), column = static_cast<Eigen::Index>(l);
      K(row, column) = K(column, row) =
          process.Correlation(apart_s, sample_strip_[k] == sample_strip_[l]);
    }
  }
  return from_samples_ * K * from_samples_.transpose();
}

}  // namespace dn::fixed_trajectory_internal
