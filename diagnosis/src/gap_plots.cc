#include <dn/diagnosis/gap_output.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

constexpr std::size_t kMostCausesDrawn = 15;
constexpr std::size_t kMaxStatistics = 30;
constexpr double kSigmasOfBand = 1.96;  // 95 %
constexpr double kBarOffset = 0.2;      // offset of two bars on one row
constexpr double kSpanOffset = 0.32;    // offset of two spans from the bar between them

std::optional<GapPlot> CausesPlot(const GapDiagnosis& d) {
  if (d.causes.empty()) return std::nullopt;
  PlotSeries evidence{"log evidence", {}, PlotStyle::kBars};
  PlotPanel panel;
  for (const GapCause& cause : d.causes) {
    if (panel.rows.size() == kMostCausesDrawn) break;
    evidence.points.emplace_back(cause.log_evidence, static_cast<double>(panel.rows.size()));
    panel.rows.push_back(fmt::format("{} ({:.2f})", cause.effect, cause.posterior));
  }
  panel.series = {evidence};
  return GapPlot{"causes.svg",
                 d.flight + ": causes with their probabilities",
                 "log evidence against absence [nats]",
                 {panel}};
}

double Deviation(const FingerprintValue& value) {
  return (value.value - value.null_mean) / value.null_sigma;
}

/// Returns the statistics that differ most from those of the assumed model.
std::vector<FingerprintValue> MostDeviating(std::vector<FingerprintValue> values) {
  std::erase_if(values, [](const FingerprintValue& v) { return !std::isfinite(Deviation(v)); });
  std::stable_sort(values.begin(), values.end(),
                   [](const FingerprintValue& a, const FingerprintValue& b) {
                     return std::abs(Deviation(a)) > std::abs(Deviation(b));
                   });
  if (values.size() > kMaxStatistics) values.resize(kMaxStatistics);
  return values;
}

void AddSpan(double middle, double half, double row, PlotSeries* spans) {
  spans->points.emplace_back(middle - half, row);
  spans->points.emplace_back(middle + half, row);
}

std::optional<GapPlot> FingerprintPlot(const GapDiagnosis& d) {
  PlotSeries model{"model, 95 %", {}, PlotStyle::kSpans};
  PlotSeries simulated{"replicates with the effects, 95 %", {}, PlotStyle::kSpans};
  PlotSeries flight{"flight", {}, PlotStyle::kBars};
  PlotPanel panel;
  for (const FingerprintValue& value : MostDeviating(d.fingerprint)) {
    const auto row = static_cast<double>(panel.rows.size());
    flight.points.emplace_back(Deviation(value), row);
    AddSpan(0.0, kSigmasOfBand, row - kSpanOffset, &model);
    if (value.simulated_mean && value.simulated_sigma) {
      AddSpan((*value.simulated_mean - value.null_mean) / value.null_sigma,
              kSigmasOfBand * *value.simulated_sigma / value.null_sigma, row + kSpanOffset,
              &simulated);
    }
    panel.rows.push_back(value.name);
  }
  if (panel.rows.empty()) return std::nullopt;
  panel.series = {flight, model, simulated};
  return GapPlot{"fingerprint.svg",
                 d.flight + ": statistics that differ from the model",
                 "difference from the mean of the model [its sigmas]",
                 {panel}};
}

/// A quantity before and after the effects are added.
struct Change {
  std::string name;
  double before, after;
};

std::vector<Change> Changes(const GapShrinkage& shrinkage) {
  const GapState& before = shrinkage.before;
  const GapState& after = shrinkage.after;
  std::vector<Change> changes{
      {"size of the gap [nats/obs]", before.size_nats_per_obs, after.size_nats_per_obs}};
  if (before.p2p_m && after.p2p_m) {
    changes.push_back({"pairs [mm]", 1e3 * *before.p2p_m, 1e3 * *after.p2p_m});
  }
  if (before.gnss_m && after.gnss_m) {
    changes.push_back({"GNSS [mm]", 1e3 * *before.gnss_m, 1e3 * *after.gnss_m});
  }
  return changes;
}

std::optional<GapPlot> BeforeAfterPlot(const GapDiagnosis& d) {
  if (!d.shrinkage) return std::nullopt;
  PlotSeries before{"before", {}, PlotStyle::kBars};
  PlotSeries after{"after", {}, PlotStyle::kBars};
  PlotPanel panel;
  for (const Change& change : Changes(*d.shrinkage)) {
    const auto row = static_cast<double>(panel.rows.size());
    before.points.emplace_back(1.0, row - kBarOffset);
    if (change.before > 0.0)
      after.points.emplace_back(change.after / change.before, row + kBarOffset);
    panel.rows.push_back(
        fmt::format("{}: {:.3g}, then {:.3g}", change.name, change.before, change.after));
  }
  panel.series = {before, after};
  return GapPlot{"before_after.svg",
                 d.flight + ": the gap without and with the effects",
                 "fraction of the value before",
                 {panel}};
}

}  // namespace

std::vector<GapPlot> GapPlots(const GapDiagnosis& diagnosis) {
  std::vector<GapPlot> plots;
  for (auto& plot :
       {CausesPlot(diagnosis), FingerprintPlot(diagnosis), BeforeAfterPlot(diagnosis)}) {
    if (plot) plots.push_back(*plot);
  }
  return plots;
}

}  // namespace dn
