#include <dn/builder/node_grid.h>
#include <dn/error.h>
#include <dn/geo/text_table.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

// Nodes closer than this are merged: far below an IMU interval, far above the resolution of the
// time.
constexpr double kSameNodeS = 1e-6;

// Limit of the memory: a node with its edges needs several kB.
constexpr double kMostNodes = 2e6;

// A node inside a gap would not be connected to the others by inertial data.
bool InsideGap(const ImuData& imu, double t_s) {
  return std::any_of(imu.gaps.begin(), imu.gaps.end(), [t_s](const ImuGap& gap) {
    return t_s > gap.t_begin_s + kSameNodeS && t_s < gap.t_end_s - kSameNodeS;
  });
}

std::vector<double> ForcedTimes(const ImuData& imu, const TimeInterval& span,
                                const std::vector<double>& gnss_t_s,
                                const NodeGridOptions& options) {
  std::vector<double> t{span.t0_s, span.t1_s};
  const auto add = [&](double t_s) {
    if (t_s > span.t0_s && t_s < span.t1_s && !InsideGap(imu, t_s)) t.push_back(t_s);
  };
  for (const double t_s : gnss_t_s) add(t_s);
  for (const ImuGap& gap : imu.gaps) {
    add(gap.t_begin_s);
    add(gap.t_end_s);
  }
  if (options.every_imu_epoch) {
    for (const ImuSample& sample : imu.samples) add(sample.t_s);
  }
  std::sort(t.begin(), t.end());
  t.erase(std::unique(t.begin(), t.end(), [](double a, double b) { return b - a < kSameNodeS; }),
          t.end());
  return t;
}

bool Overlaps(const std::vector<TimeInterval>& intervals, double t0_s, double t1_s) {
  return std::any_of(intervals.begin(), intervals.end(), [&](const TimeInterval& interval) {
    return interval.t0_s < t1_s && t0_s < interval.t1_s;
  });
}

/// Returns the number of equal parts of the interval between two forced times: an integer, at least
/// one.
double Parts(const ImuData& imu, double t0_s, double t1_s, const std::vector<TimeInterval>& dense,
             const NodeGridOptions& options) {
  const double length_s = t1_s - t0_s;
  if (options.every_imu_epoch || InsideGap(imu, t0_s + 0.5 * length_s)) return 1.0;
  const double spacing_s = Overlaps(dense, t0_s, t1_s)
                               ? std::min(1.0 / options.rate_in_strips_hz, options.max_spacing_s)
                               : options.max_spacing_s;
  return std::max(1.0, std::ceil(length_s / spacing_s - 1e-3));
}

[[noreturn]] void ThrowTooMany(double nodes) {
  throw InvalidConfig("the network would have " + FormatDouble(nodes) + " nodes, but at most " +
                      FormatDouble(kMostNodes) +
                      " fit into memory; lower network.node_rate_hz, set network.inertial: "
                      "preintegrated, or limit time_span_s");
}

}  // namespace

std::vector<double> NodeTimes(const ImuData& imu, const TimeInterval& span,
                              const std::vector<double>& gnss_t_s,
                              const std::vector<TimeInterval>& dense,
                              const NodeGridOptions& options) {
  if (!(options.rate_in_strips_hz > 0.0) || !(options.max_spacing_s > 0.0)) {
    throw InvalidConfig("node grid: rate and spacing must be positive");
  }
  if (!(span.t1_s - span.t0_s > kSameNodeS)) {
    throw InvalidInput("node grid: the time span of the network is empty");
  }
  const std::vector<double> forced = ForcedTimes(imu, span, gnss_t_s, options);
  std::vector<double> parts;  // one per interval between forced times
  double nodes_in_all = 1.0;
  for (std::size_t i = 1; i < forced.size(); ++i) {
    parts.push_back(Parts(imu, forced[i - 1], forced[i], dense, options));
    nodes_in_all += parts.back();
  }
  if (!(nodes_in_all <= kMostNodes)) ThrowTooMany(nodes_in_all);
  std::vector<double> nodes{forced.front()};
  for (std::size_t i = 1; i < forced.size(); ++i) {
    const double t0 = forced[i - 1];
    const double length = forced[i] - t0;
    for (int k = 1; k < parts[i - 1]; ++k) nodes.push_back(t0 + length * k / parts[i - 1]);
    nodes.push_back(forced[i]);
  }
  return nodes;
}

std::size_t NodeBefore(const std::vector<double>& node_t_s, double t_s) {
  const auto after = std::upper_bound(node_t_s.begin(), node_t_s.end(), t_s);
  return after == node_t_s.begin() ? 0 : static_cast<std::size_t>(after - node_t_s.begin()) - 1;
}

std::size_t NodeNear(const std::vector<double>& node_t_s, double t_s) {
  const std::size_t before = NodeBefore(node_t_s, t_s);
  const bool next =
      before + 1 < node_t_s.size() && node_t_s[before + 1] - t_s < std::abs(t_s - node_t_s[before]);
  return next ? before + 1 : before;
}

std::vector<TimeInterval> ClusterEpochs(std::vector<double> t_s, double join_s) {
  std::sort(t_s.begin(), t_s.end());
  std::vector<TimeInterval> clusters;
  for (const double t : t_s) {
    if (clusters.empty() || t - clusters.back().t1_s > join_s) clusters.push_back({t, t});
    clusters.back().t1_s = t;
  }
  return clusters;
}

}  // namespace dn
