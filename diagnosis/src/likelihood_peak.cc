#include "likelihood_peak.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <map>

namespace dn::diagnosis_internal {
namespace {

constexpr int kMostSteps = 15;
// Tolerances of the likelihood at a place relative to its prediction. The first is in nats, the
// second a fraction of its height above the neighbouring places.
constexpr double kPredictionNats = 0.02, kPredictionShare = 0.01;

struct SizeAndLikelihood {
  double x = 0.0, l = 0.0;
};

/// Fits the likelihood of errors of one size to three places. Returns its maximum if it lies
/// between them.
std::optional<LikelihoodPeak> FitOneSize(const SizeAndLikelihood& a, const SizeAndLikelihood& b,
                                         const SizeAndLikelihood& c) {
  Eigen::Matrix3d M;
  Eigen::Vector3d l;
  int row = 0;
  for (const SizeAndLikelihood& place : {a, b, c}) {  // relative to the middle one
    const double x = place.x - b.x;
    M.row(row) << 1.0, -x, -std::expm1(-2.0 * x);
    l[row++] = place.l - b.l;
  }
  const Eigen::Vector3d fit = M.fullPivLu().solve(l);
  const double n = fit[1], S = fit[2];
  if (!(n > 0.0 && S > 0.0)) return std::nullopt;
  const double x = 0.5 * std::log(2.0 * S / n);
  if (!(b.x + x > a.x && b.x + x < c.x)) return std::nullopt;
  return LikelihoodPeak{b.x + x, b.l + fit[0] - n * x - S * std::expm1(-2.0 * x),
                        1.0 / std::sqrt(2.0 * n)};
}

std::optional<LikelihoodPeak> Parabola(const SizeAndLikelihood& a, const SizeAndLikelihood& b,
                                       const SizeAndLikelihood& c) {
  const double left = (b.l - a.l) / (b.x - a.x), right = (c.l - b.l) / (c.x - b.x);
  const double curvature = 2.0 * (left - right) / (c.x - a.x);
  if (!(curvature > 0.0)) return std::nullopt;
  const double slope = left - 0.5 * curvature * (b.x - a.x);  // at b
  const double move = slope / curvature;
  if (!(b.x + move > a.x && b.x + move < c.x)) return std::nullopt;
  return LikelihoodPeak{b.x + move, b.l + 0.5 * slope * move, 1.0 / std::sqrt(curvature)};
}

class PeakSearch {
 public:
  PeakSearch(const SizeLikelihoods& likelihood, double low, double high)
      : likelihood_(likelihood), low_(low), high_(high) {}

  std::optional<LikelihoodPeak> Run(const std::vector<double>& first) {
    Ask(first);
    for (int step = 0; step < kMostSteps; ++step) {
      const auto best = Likeliest();
      if (best == known_.begin() || std::next(best) == known_.end()) {
        if (!Extend(best == known_.begin())) return std::nullopt;
        continue;
      }
      const SizeAndLikelihood a = At(std::prev(best)), b = At(best), c = At(std::next(best));
      std::optional<LikelihoodPeak> peak = FitOneSize(a, b, c);
      if (!peak) peak = Parabola(a, b, c);
      // If neither fit has a maximum, the wider interval is halved.
      const double next = peak ? peak->log_size : 0.5 * (b.x + (c.x - b.x > b.x - a.x ? c.x : a.x));
      const double l = Ask(next);
      if (!peak) continue;
      const double margin = kPredictionNats + kPredictionShare * (l - std::max(a.l, c.l));
      if (std::abs(l - peak->value) <= margin) return WithWidth(next, peak->width);
      if (next - a.x < 1e-6 * (c.x - a.x) || c.x - next < 1e-6 * (c.x - a.x)) return std::nullopt;
    }
    return std::nullopt;
  }

 private:
  using Known = std::map<double, double>;

  static SizeAndLikelihood At(Known::const_iterator known) { return {known->first, known->second}; }

  void Ask(const std::vector<double>& places) {
    const std::vector<double> l = likelihood_(places);
    for (std::size_t k = 0; k < places.size(); ++k) known_[places[k]] = l[k];
  }

  double Ask(double x) {
    Ask(std::vector<double>{x});
    return known_[x];
  }

  Known::const_iterator Likeliest() const {
    return std::max_element(known_.begin(), known_.end(),
                            [](const auto& a, const auto& b) { return a.second < b.second; });
  }

  /// Adds a place beyond an end, at twice the last distance. Returns false if the end is a bound.
  bool Extend(bool below) {
    const double end = below ? known_.begin()->first : known_.rbegin()->first;
    const double neighbour =
        below ? std::next(known_.begin())->first : std::next(known_.rbegin())->first;
    const double next = std::clamp(end + 2.0 * (end - neighbour), low_, high_);
    if (next == end) return false;
    Ask(next);
    return true;
  }

  /// Returns the maximum near x, with its width from places one width to either side.
  LikelihoodPeak WithWidth(double x, double width) {
    const double half = std::min({width, x - low_, high_ - x});
    LikelihoodPeak peak{x, known_[x], width};
    if (!(half > 0.0)) return peak;
    Ask({x - half, x + half});
    const double fall = 2.0 * known_[x] - known_[x - half] - known_[x + half];
    if (fall > 0.0) peak.width = half / std::sqrt(fall);
    return peak;
  }

  const SizeLikelihoods& likelihood_;
  double low_, high_;
  Known known_;
};

}  // namespace

std::optional<LikelihoodPeak> FindPeak(const SizeLikelihoods& likelihood,
                                       const std::vector<double>& first, double low, double high) {
  return PeakSearch(likelihood, low, high).Run(first);
}

}  // namespace dn::diagnosis_internal
