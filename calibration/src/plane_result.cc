#include <dn/calibration/result_files.h>

#include "model_check_json.h"
#include "result_json.h"

namespace dn {
namespace {

Json StripsJson(const PlaneAdjustment& adjustment, const std::vector<std::string>& strips) {
  Json json = Json::object();
  for (const auto& [pair, planes] : adjustment.planes_of_strips) {
    json[strips.at(static_cast<std::size_t>(pair.first)) + "-" +
         strips.at(static_cast<std::size_t>(pair.second))] = planes;
  }
  return json;
}

Json PlanesJson(const PlaneCalibration& calibration, const std::vector<std::string>& strips) {
  const PlaneAdjustment& adjustment = calibration.adjustment;
  return {{"found", calibration.problem.planes.size()},
          {"kept", adjustment.planes_kept},
          {"normal_spread", ToJson(adjustment.normals.eigenvalues)},
          {"strip_pairs", StripsJson(adjustment, strips)}};
}

}  // namespace

Json CalibrationJson(const std::string& flight, const PlaneCalibration& calibration,
                     const std::vector<std::string>& strips, const RunTimings& timings) {
  const BoresightResult& boresight = calibration.boresight;
  Json json;
  json["schema"] = "dn.result/1";
  json["flight"] = flight;
  json["method"] = "planes";
  json["boresight"] = internal::BoresightJson(boresight);
  json["assessment"] = internal::AssessmentJson(boresight);
  json["correlations"] = nullptr;
  json["estimates"] =
      calibration.unknowns.empty() ? Json(nullptr) : internal::UnknownsJson(calibration.unknowns);
  json["clocks"] = nullptr;
  Json figures = AdjustmentJson(calibration.figures);
  figures["condition_number"] = boresight.condition_number;
  figures["residual_initial_m"] = calibration.adjustment.residual_initial_m;
  figures["residual_final_m"] = calibration.adjustment.residual_final_m;
  for (const char* key : {"nodes", "imu_epochs", "gnss_epochs"}) figures[key] = nullptr;
  json["adjustment"] = figures;
  json["planes"] = PlanesJson(calibration, strips);
  json["strip_pairs"] = nullptr;
  json["model_check"] = ModelCheckJson(calibration.model_check);
  json["timing_s"] = internal::TimingJson(timings);
  return json;
}

}  // namespace dn
