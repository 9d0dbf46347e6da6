#include <dn/axis_names.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <dn/names.h>
#include <dn/study/sweep.h>
#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "csv_field.h"

namespace dn {
namespace {

/// Returns the numbers of a design in the order of the columns; empty if the design failed.
std::vector<double> RecordNumbers(const SweepRecord& record) {
  if (!record.failure.empty()) return {};
  const Eigen::Vector3d sigma_deg = record.sigma_rad * kDegPerRad;
  return {sigma_deg.x(),
          sigma_deg.y(),
          sigma_deg.z(),
          record.condition_number,
          std::max(record.correlation_angles, record.correlation_biases),
          record.correlation_angles,
          record.correlation_biases,
          record.strips.roll_pitch_rad * kDegPerRad,
          record.strips.yaw_rad * kDegPerRad,
          record.strips.position_m};
}

constexpr const char* kColumns[] = {
    "sigma_roll_deg",      "sigma_pitch_deg",      "sigma_yaw_deg",      "condition_number",
    "largest_correlation", "correlation_angles",   "correlation_biases", "trajectory_rp_deg",
    "trajectory_yaw_deg",  "trajectory_position_m"};

std::string PlotFile(const std::string& path) {
  std::string name = "sweep_";
  for (const char c : path) name += std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
  return name + ".svg";
}

/// Returns the labels of a key in the order of the designs.
std::vector<std::string> KeyLabels(const std::vector<SweepRecord>& records, std::size_t key) {
  std::vector<std::string> labels;
  for (const SweepRecord& record : records) {
    if (std::find(labels.begin(), labels.end(), record.labels[key]) == labels.end()) {
      labels.push_back(record.labels[key]);
    }
  }
  return labels;
}

}  // namespace

std::string SweepCsv(const std::vector<std::string>& paths,
                     const std::vector<SweepRecord>& records) {
  std::string text = "design";
  for (const std::string& path : paths) text += "," + CsvField(path);
  for (const char* column : kColumns) text += std::string(",") + column;
  text += ",singular\n";
  for (const SweepRecord& record : records) {
    text += std::to_string(record.number);
    for (const std::string& label : record.labels) text += "," + CsvField(label);
    const std::vector<double> numbers = RecordNumbers(record);
    for (std::size_t k = 0; k < std::size(kColumns); ++k) {
      text += ",";
      if (!numbers.empty()) text += FormatDouble(numbers[k]);
    }
    text += "," + CsvField(WithoutControls(record.failure)) + "\n";
  }
  return text;
}

Json SweepJson(const std::vector<std::string>& paths, const std::vector<SweepRecord>& records) {
  Json designs = Json::array();
  for (const SweepRecord& record : records) {
    Json design = {
        {"number", record.number}, {"labels", record.labels}, {"singular", record.failure}};
    const std::vector<double> numbers = RecordNumbers(record);
    if (!numbers.empty()) {
      design["sigma_deg"] = {numbers[0], numbers[1], numbers[2]};
      for (std::size_t k = 3; k < numbers.size(); ++k) design[kColumns[k]] = numbers[k];
    }
    designs.push_back(std::move(design));
  }
  return {{"schema", "dn.sweep/1"}, {"keys", paths}, {"designs", designs}};
}

std::string SweepTable(const std::vector<std::string>& paths,
                       const std::vector<SweepRecord>& records) {
  constexpr std::size_t kMostShown = 24;
  constexpr std::size_t kMostReason = 60;
  const auto shortened = [](const std::string& text, std::size_t most) {
    return text.size() > most ? text.substr(0, most - 3) + "..." : text;
  };
  std::string text = fmt::format("{:>6}", "design");
  for (const std::string& path : paths) {
    text += fmt::format(" {:>{}}", shortened(path, kMostShown), kMostShown);
  }
  text += fmt::format(" {:>10} {:>10} {:>10} {:>9} {:>8}\n", "roll [deg]", "pitch", "yaw",
                      "condition", "corr [%]");
  for (const SweepRecord& record : records) {
    text += fmt::format("{:>6}", record.number);
    for (const std::string& label : record.labels) {
      text += fmt::format(" {:>{}}", shortened(label, kMostShown), kMostShown);
    }
    const std::vector<double> n = RecordNumbers(record);
    text += n.empty() ? " singular: " + shortened(WithoutControls(record.failure), kMostReason)
                      : fmt::format(" {:>10.6f} {:>10.6f} {:>10.6f} {:>9.1f} {:>8.1f}", n[0], n[1],
                                    n[2], n[3], 100.0 * n[4]);
    text += "\n";
  }
  return text;
}

std::vector<StudyPlot> SweepPlots(const std::vector<std::string>& paths,
                                  const std::vector<SweepRecord>& records) {
  std::vector<StudyPlot> plots;
  for (std::size_t key = 0; key < paths.size(); ++key) {
    const std::vector<std::string> labels = KeyLabels(records, key);
    if (labels.size() < 2) continue;
    PlotPanel panel;
    panel.rows = labels;
    for (int i = 0; i < 3; ++i) {
      PlotSeries series{kRollPitchYaw[i], {}, PlotStyle::kPoints};
      for (const SweepRecord& record : records) {
        if (!record.failure.empty()) continue;
        const auto row = std::find(labels.begin(), labels.end(), record.labels[key]);
        series.points.emplace_back(1e3 * kDegPerRad * record.sigma_rad[i],
                                   static_cast<double>(row - labels.begin()) + 0.2 * (i - 1));
      }
      if (!series.points.empty()) panel.series.push_back(std::move(series));
    }
    if (panel.series.empty()) continue;
    plots.push_back({PlotFile(paths[key]),
                     "boresight by " + paths[key] + ", one point per design",
                     "standard deviation [mdeg]",
                     {panel}});
  }
  return plots;
}

}  // namespace dn
