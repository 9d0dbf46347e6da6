#include <dn/axis_names.h>
#include <dn/diagnosis/result_files.h>
#include <dn/diagnosis/scanner_mountings.h>
#include <dn/report/value_words.h>
#include <fmt/format.h>

#include "result_json.h"

namespace dn {
namespace {

Json LeverArmJson(const RelativeMounting& relative, bool with_values) {
  if (!relative.lever_arm_b_m) return nullptr;
  Json json{{"sigma_m", ToJson(relative.lever_arm_sigma_m())},
            {"covariance_m2", ToJsonMatrix(relative.lever_arm_covariance_m2)}};
  if (with_values) json["value_m"] = ToJson(*relative.lever_arm_b_m);
  return json;
}

Json RelativeJson(const RelativeMounting& relative, bool with_values) {
  Json json{{"scanners", {relative.from, relative.to}},
            {"sigma_deg", ToJson(relative.sigma_rad() * kDegPerRad)},
            {"covariance_deg2", ToJsonMatrix(relative.covariance_rad2 * kDegPerRad * kDegPerRad)},
            {"lever_arm", LeverArmJson(relative, with_values)}};
  if (with_values) json["angles_deg"] = ToJson(relative.angles_rad * kDegPerRad);
  return json;
}

void AddRelative(const ScannerMountings& mountings, bool with_values, Json* json) {
  (*json)["relative_boresight"] = Json::array();
  for (const RelativeMounting& relative : mountings.relative) {
    (*json)["relative_boresight"].push_back(RelativeJson(relative, with_values));
  }
}

std::string ThreeWithSigma(const Eigen::Vector3d& value, const Eigen::Vector3d& sigma) {
  std::string text;
  for (int i = 0; i < 3; ++i) text += " " + FormatWithSigma(value[i], sigma[i]);
  return text;
}

}  // namespace

void AddScannersJson(const ScannerMountings& mountings, Json* json) {
  if (mountings.scanners.empty()) return;
  (*json)["scanners"] = Json::array();
  for (const ScannerBoresight& scanner : mountings.scanners) {
    (*json)["scanners"].push_back(
        {{"name", scanner.name},
         {"boresight", diagnosis_internal::BoresightJson(scanner.boresight)},
         {"assessment", diagnosis_internal::AssessmentJson(scanner.boresight)}});
  }
  AddRelative(mountings, true, json);
}

void AddPredictedScannersJson(const ScannerMountings& mountings, Json* json) {
  if (mountings.scanners.empty()) return;
  (*json)["scanners"] = Json::array();
  for (const ScannerBoresight& scanner : mountings.scanners) {
    (*json)["scanners"].push_back(
        {{"name", scanner.name}, {"boresight", PredictedBoresightJson(scanner.boresight)}});
  }
  AddRelative(mountings, false, json);
}

std::string ScannersSummary(const ScannerMountings& mountings) {
  std::string text;
  if (mountings.scanners.empty()) return text;
  text += "boresight of each scanner [deg], roll, pitch, yaw\n";
  for (const ScannerBoresight& scanner : mountings.scanners) {
    text += fmt::format("  {:<12}{}\n", scanner.name,
                        ThreeWithSigma(scanner.boresight.angles_rad * kDegPerRad,
                                       scanner.boresight.sigma_rad() * kDegPerRad));
  }
  for (const RelativeMounting& relative : mountings.relative) {
    const std::string name = relative.from + " to " + relative.to;
    text += fmt::format(
        "  {:<12}{}, relative\n", name,
        ThreeWithSigma(relative.angles_rad * kDegPerRad, relative.sigma_rad() * kDegPerRad));
    if (!relative.lever_arm_b_m) continue;
    text += fmt::format("  {:<12}{}, relative lever arm [m]\n", name,
                        ThreeWithSigma(*relative.lever_arm_b_m, relative.lever_arm_sigma_m()));
  }
  return text;
}

}  // namespace dn
