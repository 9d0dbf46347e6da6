#include "window_scan.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dn {
namespace {

constexpr std::size_t kReachInGroups = 2;

/// Returns every `step`-th cell from `begin` on, and `end`.
std::vector<std::size_t> Edges(std::size_t begin, std::size_t end, std::size_t step) {
  std::vector<std::size_t> edges;
  for (std::size_t cell = begin; cell < end; cell += step) edges.push_back(cell);
  edges.push_back(end);
  return edges;
}

bool IsNear(std::size_t a, std::size_t b, std::size_t reach) {
  return a < b + reach && b < a + reach;
}

}  // namespace

WindowScan::WindowScan(const HighBand& band, const NoiseCheckOptions& options,
                       const std::vector<RunningSums>& sums, bool with_scale, std::size_t group)
    : band_(band),
      sums_(sums),
      with_scale_(with_scale),
      group_(group),
      reach_(kReachInGroups * group),
      prior_(options.typical_ratio) {
  for (const ImuTriad triad : kBothTriads) {
    levels_.emplace_back(band.triads[triad].rounding);
    additions_.emplace_back(options.typical_sigma[triad], band.triads[triad].assumed_sigma,
                            options.spread_decades);
  }
  SeeAll();
}

bool WindowScan::AddOutside(const CellSpan& span, ImuTriad triad, Case* one) const {
  constexpr double kLeastOutside = 0.1;
  BandEnergy& inside = one->inside[triad];
  const BandEnergy outside = sums_[triad].Outside(sums_[triad].Inside(span));
  if (outside.dof < kLeastOutside * sums_[triad].All().dof) return false;
  const double base = outside.Variance();
  const double of_inside = inside.dof > 0.0 ? LogLikelihood(inside, base) : 0.0;
  one->evidence += LevelEvidence(levels_[triad].Level(outside), prior_) + of_inside;
  one->log_likelihood += LogLikelihood(outside, base) + of_inside;
  one->base[triad] = base;
  inside.sum /= base;
  return true;
}

std::optional<WindowScan::Case> WindowScan::EvaluateSpan(const CellSpan& span) const {
  Case one;
  for (const ImuTriad triad : kBothTriads) {
    one.inside[triad] = sums_[triad].Inside(span);
    if (with_scale_ && IsUsable(triad) && !AddOutside(span, triad, &one)) return std::nullopt;
    one.evidence += additions_[triad].Evidence(one.inside[triad], one.base[triad]);
    one.log_likelihood += BestAddition(one.inside[triad]);
  }
  return one;
}

void WindowScan::See(const CellSpan& span, const Case& one, double weight, Seen* seen) {
  seen->sum.Add(one.evidence + std::log(weight));
  seen->weight += weight;
  if (one.log_likelihood <= seen->best) return;
  seen->best = one.log_likelihood;
  seen->likeliest = span;
}

void WindowScan::SeeAll() {
  // Number of windows of cells that one coarse window represents.
  const auto weight = static_cast<double>(group_ * group_);
  std::vector<std::pair<CellSpan, Case>> coarse;
  Seen groups;
  const std::vector<std::size_t> edges = Edges(0, band_.windows.size(), group_);
  for (std::size_t i = 0; i < edges.size(); ++i) {
    for (std::size_t k = i + 1; k < edges.size(); ++k) {
      const CellSpan span{edges[i], edges[k]};
      const std::optional<Case> one = EvaluateSpan(span);
      if (!one) continue;
      See(span, *one, weight, &groups);
      coarse.emplace_back(span, *one);
    }
  }
  if (coarse.empty()) return;
  const CellSpan about = groups.likeliest;
  for (const auto& [span, one] : coarse) {
    if (IsNear(span.first, about.first, reach_) && IsNear(span.past, about.past, reach_)) continue;
    See(span, one, weight, &seen_);
  }
  SeeNear(about);
}

void WindowScan::SeeNear(const CellSpan& about) {
  for (const std::size_t first : Around(about.first)) {
    for (const std::size_t past : Around(about.past)) {
      if (first >= past) continue;
      const CellSpan span{first, past};
      if (const std::optional<Case> one = EvaluateSpan(span)) See(span, *one, 1.0, &seen_);
    }
  }
}

std::vector<std::size_t> WindowScan::Around(std::size_t edge) const {
  const std::size_t begin = edge >= reach_ ? edge - reach_ + 1 : 0;
  return Edges(begin, std::min(edge + reach_ - 1, band_.windows.size()), 1);
}

double WindowScan::Evidence() const {
  return seen_.weight > 0.0 ? seen_.sum.Value() - std::log(seen_.weight) : kLogZero;
}

void WindowScan::AddTriad(const Case& one, ImuTriad triad, NoiseWindow* window) const {
  const TriadSamples& samples = band_.triads[triad];
  const BandEnergy& inside = one.inside[triad];
  const double unit2 =
      one.base[triad] * (1.0 + samples.rounding) * std::pow(samples.assumed_sigma, 2);
  const double variance = std::max(0.0, inside.Variance() - 1.0) * unit2;
  const double uncertainty = std::max(1.0, inside.Variance()) * std::sqrt(2.0 / inside.dof) * unit2;
  window->sigma[triad] = std::sqrt(variance);
  window->sigma_of_sigma[triad] =
      variance > uncertainty ? 0.5 * uncertainty / std::sqrt(variance) : std::sqrt(uncertainty);
}

WindowScan::Case WindowScan::WithoutEnds(const CellSpan& span, const Case& one) const {
  constexpr std::size_t kFewestCells = 5;
  if (span.past - span.first < kFewestCells) return one;
  Case middle = one;
  for (const ImuTriad triad : kBothTriads) {
    middle.inside[triad] = sums_[triad].Inside({span.first + 1, span.past - 1});
    middle.inside[triad].sum /= one.base[triad];
  }
  return middle;
}

std::optional<NoiseWindow> WindowScan::Likeliest() const {
  if (!(seen_.weight > 0.0)) return std::nullopt;
  const CellSpan& span = seen_.likeliest;
  const Case one = *EvaluateSpan(span);
  NoiseWindow window;
  window.t0_s = band_.windows[span.first].t0_s;
  window.t1_s = band_.windows[span.past - 1].t1_s;
  window.log_likelihood = one.log_likelihood;
  window.log_likelihood_against_scale = one.log_likelihood;
  const Case of_size = WithoutEnds(span, one);
  for (const ImuTriad triad : kBothTriads) {
    if (IsUsable(triad)) {
      window.log_likelihood_against_scale -=
          levels_[triad].Level(sums_[triad].All()).log_likelihood;
    }
    if (of_size.inside[triad].dof > 0.0) AddTriad(of_size, triad, &window);
  }
  if (window.sigma[kGyroTriad] + window.sigma[kAccelTriad] == 0.0) return std::nullopt;
  return window;
}

}  // namespace dn
