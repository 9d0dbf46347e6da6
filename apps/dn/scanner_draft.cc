#include "scanner_draft.h"

#include <dn/files/yaml_sections.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <fmt/format.h>

#include "data_hints.h"

namespace dn::apps {
namespace {

std::string ListText(const Eigen::Vector3d& v) {
  return fmt::format("[{}, {}, {}]", FormatDouble(v[0]), FormatDouble(v[1]), FormatDouble(v[2]));
}

constexpr const char* kNoLeverArm =
    "lever_arm_m: [0, 0, 0]        # MISSING: scanner in body, forward right down, m";

std::string JoinLines(const std::vector<std::string>& lines, const std::string& indent) {
  std::string text;
  for (const std::string& line : lines) text += indent + line + "\n";
  return text;
}

std::vector<std::string> MountingComment(const ShownMounting& mounting) {
  switch (mounting.source) {
    case ShownMounting::Source::kTrajectory:
      return {
          fmt::format("# This mounting leads from the laser vectors to the points, to {:.3f} m "
                      "rms.",
                      mounting.rms_m)};
    case ShownMounting::Source::kCourse:
      return {"# GUESS: with this mounting, the laser vectors lead to the points from a level body",
              fmt::format("# along the course of the GNSS positions, to {:.0f} m rms.",
                          mounting.rms_m)};
    case ShownMounting::Source::kChosen:
      break;
  }
  return {
      "# The points have no laser vectors. These are computed with this mounting, so that the",
      "# axes of the scanner are a choice: the first is nadir, the beams turn about the second."};
}

Eigen::Vector3d Rounded(const Eigen::Vector3d& v, double unit) {
  const Eigen::Array3d steps = (v / unit).array().round();
  return unit * (steps + 0.0).matrix();  // without -0
}

/// Returns the keys of the mounting that the points of the strips show.
std::string ShownMountingText(const StripScanner& scanner, const std::string& indent) {
  const ShownMounting& mounting = *scanner.mounting;
  std::vector<std::string> lines = MountingComment(mounting);
  lines.push_back("R_sensor_to_body: " + MatrixText(mounting.R_bs));
  lines.push_back("scan_axis: " + ListText(scanner.axes.scan_s));
  lines.push_back("nadir_axis: " + ListText(scanner.axes.nadir_s));
  if (mounting.source == ShownMounting::Source::kTrajectory) {
    lines.push_back(
        "boresight_deg: " + ListText(Rounded(kDegPerRad * mounting.boresight_rad, 1e-4)) +
        "   # of the points; a start");
  }
  lines.push_back(mounting.lever_arm_b_m
                      ? "lever_arm_m: " + ListText(Rounded(*mounting.lever_arm_b_m, 1e-3)) +
                            "   # of the points, as for R_sensor_to_body"
                      : kNoLeverArm);
  return JoinLines(lines, indent);
}

}  // namespace

std::string MountingText(const ScannerAxes& axes, const std::string& indent) {
  Eigen::Matrix3d R_bs;
  R_bs << axes.scan_s.transpose(), axes.nadir_s.cross(axes.scan_s).transpose(),
      axes.nadir_s.transpose();
  return JoinLines(
      {"# From the laser vectors: the nadir axis is their main direction, and the scan axis is the",
       "# one with their smallest component. That the scan axis points forward is a GUESS: reverse",
       "# it if it points back.", "R_sensor_to_body: " + MatrixText(R_bs),
       "scan_axis: " + ListText(axes.scan_s), "nadir_axis: " + ListText(axes.nadir_s), kNoLeverArm},
      indent);
}

std::string ScannersText(const std::vector<StripScanner>& scanners,
                         const std::string& georeferencing) {
  if (scanners.empty()) {
    return georeferencing.empty() ? "" : "\n# lidar:\n" + georeferencing;
  }
  std::string text =
      "\nlidar:             # pairs: dn match or dn calibrate find them in the strips\n";
  for (const StripScanner& scanner : scanners) {
    const bool listed = !scanner.name.empty();
    if (listed) text += fmt::format("  - name: {}\n", QuoteYaml(scanner.name));
    const std::string indent = listed ? "    " : "  ";
    text +=
        fmt::format("{}# The beams turn about scan_axis from {:.1f} to {:.1f} deg, from nadir.\n",
                    indent, scanner.low_deg, scanner.high_deg);
    text +=
        scanner.mounting ? ShownMountingText(scanner, indent) : MountingText(scanner.axes, indent);
    text += indent + (scanner.gsd_m
                          ? fmt::format("gsd_m: {:.2g}                   # spacing of the points\n",
                                        *scanner.gsd_m)
                          : "sigma_p_m: 0.1                # assumed; the pairs of dn match have "
                            "their own\n");
  }
  text += georeferencing;
  const std::string& crs = scanners.front().crs;
  if (!crs.empty() && crs != "map") {
    text +=
        fmt::format("\nstrips_crs: {}            # GUESS: the points lie about the path\n", crs);
  }
  return text;
}

void AddMissingMountings(const std::vector<StripScanner>& scanners,
                         std::vector<std::string>* missing) {
  for (const StripScanner& scanner : scanners) {
    const std::string whose = scanner.name.empty() ? "" : " of scanner " + scanner.name;
    using Source = ShownMounting::Source;
    const bool sure = scanner.mounting && scanner.mounting->source != Source::kCourse;
    const bool lever_arm = scanner.mounting && scanner.mounting->lever_arm_b_m;
    if (lever_arm) continue;
    missing->push_back((sure ? "lidar.lever_arm_m" : "lidar.lever_arm_m, lidar.R_sensor_to_body") +
                       whose);
  }
}

}  // namespace dn::apps
