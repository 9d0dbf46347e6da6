#include "certificate.h"

#include <dn/axis_names.h>
#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "sections.h"

namespace dn::page_internal {
namespace {

constexpr std::size_t kMostContributions = 6;
constexpr std::size_t kMostStripPairs = 8;
constexpr std::size_t kMostInputs = 12;

std::string ThreeNumbers(const Eigen::Vector3d& v) {
  return fmt::format("{:.4g}, {:.4g}, {:.4g}", v.x(), v.y(), v.z());
}

/// Returns what the configuration says of the sensors.
Table Sensors(const FlightConfig& config) {
  Table table{"Sensors", {"", ""}, {}};
  const auto add = [&](const char* name, const std::string& text) {
    table.rows.push_back(Row(name, {Text(text)}));
  };
  if (config.imu) {
    const ImuModel& model = config.imu->model;
    add("inertial unit", config.imu->grade.value_or("by the noise below"));
    add("gyro white noise [deg/sqrt(h)]",
        fmt::format("{:.3g}", model.gyro.white / RadPerSqrtSFromDegPerSqrtHour(1.0)));
    add("accelerometer white noise [m/s/sqrt(h)]",
        fmt::format("{:.3g}", model.accel.white / MpsPerSqrtSFromMpsPerSqrtHour(1.0)));
  }
  if (config.gnss) {
    add("antenna lever arm, forward right down [m]", ThreeNumbers(config.gnss->lever_arm_b_m));
  }
  if (config.lidar) {
    if (!config.lidar->name.empty()) add("scanner", config.lidar->name);
    add("scanner lever arm, forward right down [m]",
        ThreeNumbers(config.lidar->mounting.lever_arm_b_m));
    add("sigma of a pair [m]", fmt::format("{:.3g}", config.lidar->sigma_p_m));
  }
  return table;
}

Table CertifiedAngles(const Facts& boresight) {
  Table table = AngleTable("Boresight, a rotation vector about forward, right, down");
  table.rows.push_back(Row("angle [deg]", Three(boresight["angles_deg"], 5)));
  table.rows.push_back(Row("sigma [deg]", Three(boresight["sigma_deg"], 5)));
  if (boresight["euler_zyx_deg"]) {
    table.rows.push_back(
        Row("Euler angles, order yaw, pitch, roll [deg]", Three(boresight["euler_zyx_deg"], 5)));
  }
  table.rows.push_back(
      Row("sigma of the pure model [deg]", Three(boresight["as_modelled"]["sigma_deg"], 5)));
  for (std::size_t r = 0; r < 3; ++r) {
    table.rows.push_back(Row(std::string("covariance [mdeg²], ") + kRollPitchYaw[r],
                             Three(boresight["covariance_deg2"][r], 3, 1e6)));
  }
  return table;
}

Table LargestParts(const Facts& boresight) {
  Table table = AngleTable("Largest parts of the sigmas [mdeg]");
  for (const Facts& part : boresight["contributions"].elements()) {
    if (table.rows.size() == kMostContributions) break;
    table.rows.push_back(Row(part["effect"].text(), Three(part["sigma_deg"], 2, 1e3)));
  }
  return table;
}

/// Returns the control by the surfaces of the strips: rms of their height differences. Without
/// rows if the strips were not georeferenced.
Table SurfaceControl(const ResultFolder& folder) {
  Table table{"Control: rms of the height differences of the strips on flat ground [m]",
              {"", "cells", "before", "after"},
              {},
              ""};
  for (const Facts& pair : folder.Read("georef.json")["strip_differences"].elements()) {
    if (table.rows.size() == kMostStripPairs) break;
    table.rows.push_back(Row(pair["strips"][0].text() + "-" + pair["strips"][1].text(),
                             {pair["after"]["cells"].Count(), pair["before"]["rms_m"].Decimals(3),
                              pair["after"]["rms_m"].Decimals(3)}));
  }
  return table;
}

/// Returns the control by the pairs of strips: mean differences before and after.
Table PairControl(const Facts& result) {
  Table table{"Control: mean distance of the pairs [m]", {"", "pairs", "before", "after"}, {}, ""};
  const std::vector<Facts> pairs = result["strip_pairs"].elements();
  for (const Facts& pair : pairs) {
    if (table.rows.size() == kMostStripPairs) break;
    table.rows.push_back(
        Row(pair["strips"].text(), {pair["pairs"].Count(), pair["before"]["mean_m"].Decimals(3),
                                    pair["after"]["mean_m"].Decimals(3)}));
  }
  if (pairs.empty()) {
    const Facts adjustment = result["adjustment"];
    table.rows.push_back(Row(
        "all", {adjustment["correspondences"].Count(), adjustment["residual_initial_m"].Decimals(3),
                adjustment["residual_final_m"].Decimals(3)}));
  }
  if (pairs.size() > kMostStripPairs) {
    table.note = fmt::format("{} more pairs of strips", pairs.size() - kMostStripPairs);
  }
  return table;
}

Table CertifiedInputs(const Facts& report) {
  Table table{"Inputs", {"file", "SHA-256"}, {}, ""};
  const std::vector<Facts> inputs = report["inputs"].elements();
  for (std::size_t k = 0; k < std::min(inputs.size(), kMostInputs); ++k) {
    table.rows.push_back({Text(inputs[k]["file"].text()), Text(inputs[k]["sha256"].text())});
  }
  if (inputs.size() > kMostInputs) {
    table.note = fmt::format("{} more files: report.json", inputs.size() - kMostInputs);
  }
  return table;
}

}  // namespace

std::vector<Section> Certificate(const ResultFolder& folder, const Calibrated& calibrated) {
  const Facts& result = calibrated.result;
  const Headline headline = CalibrationHeadline(calibrated, true);
  Section verdict{"Boresight calibration: " + result["flight"].text(),
                  {Paragraph{headline.word + ". " + headline.answer, headline.tone}}};
  for (const std::string& reason : headline.reasons) {
    verdict.contents.emplace_back(Paragraph{reason, headline.tone});
  }
  verdict.contents.emplace_back(CertifiedAngles(result["boresight"]));
  Table parts = LargestParts(result["boresight"]);
  if (!parts.rows.empty()) verdict.contents.emplace_back(std::move(parts));
  Table control = SurfaceControl(folder);
  verdict.contents.emplace_back(control.rows.empty() ? PairControl(result) : std::move(control));
  Section basis{"Basis", {}};
  if (const auto config = folder.Config()) basis.contents.emplace_back(Sensors(*config));
  basis.contents.emplace_back(CertifiedInputs(folder.report()));
  return {std::move(verdict), std::move(basis)};
}

}  // namespace dn::page_internal
