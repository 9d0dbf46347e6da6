#include <dn/axis_names.h>
#include <dn/files/flight.h>

#include <algorithm>
#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

constexpr std::size_t kSigmaColumns = 10;
constexpr std::size_t kBiasColumns = 13;
constexpr std::size_t kSeparationColumns = 7;
// Spacing of the path on the map, shorter than any bend in the path of an aircraft.
constexpr double kMapSpacingS = 0.5;

/// Returns the poses of trajectory.out in the mapping frame of the flight, thinned.
std::vector<MapPose> ReadPath(const ResultFolder& folder, const FlightConfig& config) {
  if (!folder.Has("trajectory.out") || !config.origin) return {};
  const LocalFrame frame(*config.origin);
  std::vector<MapPose> path;
  for (const NavPoint& point : ReadSbetThinned(folder.FilePath("trajectory.out"), kMapSpacingS)) {
    path.push_back(ToMapPose(point, frame));
  }
  return path;
}

Curve PathLine(const std::string& label, const std::vector<MapPose>& path, double t0_s,
               double t1_s) {
  Curve line{label, {}, {}};
  for (const MapPose& pose : path) {
    if (pose.t_s < t0_s || pose.t_s > t1_s) continue;
    line.x.push_back(pose.p_mb.x());
    line.y.push_back(pose.p_mb.y());
  }
  return line;
}

void AddMap(const ResultFolder& folder, Section* section) {
  const std::optional<FlightConfig> config = folder.Config();
  if (!config) return;
  const std::vector<MapPose> path = ReadPath(folder, *config);
  if (path.empty()) return;
  MapChart map{"Path of the flight", {}};
  map.lines.push_back(PathLine("path", path, path.front().t_s, path.back().t_s));
  for (const StripInterval& strip : config->strips) {
    map.lines.push_back(PathLine("strip " + strip.name, path, strip.t0_s, strip.t1_s));
  }
  section->contents.emplace_back(Chart{std::move(map)});
}

/// Returns a chart of columns of a table over the time since its first row.
SeriesChart OverTime(const std::string& title, const std::string& y_label, const TextTable& table,
                     const std::vector<std::string>& labels, std::size_t first) {
  SeriesChart chart{title, "time since start [s]", y_label, {}};
  for (std::size_t k = 0; k < labels.size(); ++k) {
    chart.curves.push_back(
        OnScreen({labels[k], Column(table, 0, table.row(0)[0]), Column(table, first + k)}));
  }
  return chart;
}

/// Returns a chart of three columns over the time since the first row, with bands of one sigma. The
/// sigmas are in the three columns that begin at `sigma`.
SeriesChart WithBands(const std::string& title, const std::string& y_label, const TextTable& table,
                      std::size_t first, std::size_t sigma) {
  SeriesChart chart{title, "time since start [s]", y_label, {}};
  for (std::size_t k = 0; k < 3; ++k) {
    Curve curve{kXyz[k], Column(table, 0, table.row(0)[0]), Column(table, first + k)};
    for (std::size_t row = 0; row < table.rows(); ++row) {
      const double half = table.row(row)[sigma + k];
      curve.low.push_back(curve.y[row] - half);
      curve.high.push_back(curve.y[row] + half);
    }
    chart.curves.push_back(OnScreen(curve));
  }
  return chart;
}

void AddSeparation(const ResultFolder& folder, Section* section) {
  const auto separation = folder.Numbers("filter_separation.txt", kSeparationColumns);
  if (!separation || separation->rows() == 0) return;
  section->contents.emplace_back(Chart{
      OverTime("Forward minus reverse filter, position", "[m]", *separation, AxisNames(kEnu), 1)});
  section->contents.emplace_back(Chart{OverTime("Forward minus reverse filter, attitude", "[deg]",
                                                *separation, AxisNames(kAttitudeAngles), 4)});
}

}  // namespace

Section TrajectorySection(const ResultFolder& folder) {
  Section section{"Trajectory", {}};
  AddMap(folder, &section);
  if (const auto sigma = folder.Numbers("trajectory_sigma.txt", kSigmaColumns)) {
    section.contents.emplace_back(
        Chart{OverTime("Standard deviation of the position", "[m]", *sigma, AxisNames(kEnu), 1)});
    section.contents.emplace_back(Chart{OverTime("Standard deviation of the attitude", "[deg]",
                                                 *sigma, AxisNames(kAttitudeAngles), 7)});
  }
  AddSeparation(folder, &section);
  const Facts errors = folder.report()["reference_errors"];
  if (!errors) return section;
  Table table{"Differences from the reference trajectory (root mean squares at the nodes)",
              {"", "", "", ""},
              {}};
  for (const std::string& key : errors.keys()) {
    if (errors[key][0]) table.rows.push_back(Row(key, Three(errors[key], 5)));
  }
  section.contents.emplace_back(std::move(table));
  return section;
}

Section BiasSection(const ResultFolder& folder) {
  Section section{"Inertial biases", {}};
  const auto biases = folder.Numbers("biases.txt", kBiasColumns);
  if (!biases) return section;
  section.contents.emplace_back(
      Chart{WithBands("Gyro, with a band of one sigma", "[deg/h]", *biases, 1, 7)});
  section.contents.emplace_back(
      Chart{WithBands("Accelerometer, with a band of one sigma", "[mg]", *biases, 4, 10)});
  return section;
}

Section BiasCorrelationSection(const Facts& correlations) {
  Section section{"Correlation of the boresight with the biases", {}};
  Table table{
      "",
      {"with the bias of the", "largest [%]", "rms [%]"},
      {},
      "Over all nodes and axes. A large value means that the boresight depends on the accuracy of "
      "the bias."};
  for (const auto& [key, name] : {std::pair("boresight_to_accel_bias", "accelerometers"),
                                  {"boresight_to_gyro_bias", "gyros"}}) {
    const Facts of = correlations[key];
    if (!of) continue;
    section.contents.emplace_back(
        Chart{Correlations(std::string("With the ") + name + " at the lidar barycentre [%]",
                           AxisNames(kRollPitchYaw), AxisNames(kXyz), of["at_barycentre"])});
    table.rows.push_back(Row(name, {of["max_abs"].Decimals(1, 100), of["rms"].Decimals(1, 100)}));
  }
  if (!table.rows.empty()) section.contents.emplace_back(std::move(table));
  return section;
}

}  // namespace dn::page_internal
