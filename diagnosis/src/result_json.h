#pragma once

#include <dn/diagnosis/result_files.h>

#include <string>
#include <vector>

#include "model_check_json.h"

namespace dn::diagnosis_internal {

/// These functions return the sections of result.json that all methods have.
Json BoresightJson(const BoresightResult& boresight);
Json AssessmentJson(const BoresightResult& boresight);
Json TimingJson(const RunTimings& timings);

/// Returns result.json of a method on a fixed trajectory. `compared` has the sections of the
/// compared data: pairs or planes.
template <class Calibration>
Json FixedTrajectoryJson(const std::string& flight, const char* method,
                         const Calibration& calibration, const ModelCheck& check,
                         const Json& compared, const RunTimings& timings) {
  Json json;
  json["schema"] = "dn.result/1";
  json["flight"] = flight;
  json["method"] = method;
  json["boresight"] = BoresightJson(calibration.boresight);
  json["assessment"] = AssessmentJson(calibration.boresight);
  for (const char* key : {"correlations", "estimates", "clocks"}) json[key] = nullptr;
  Json& figures = json["adjustment"] = AdjustmentJson(calibration.figures);
  figures["condition_number"] = calibration.boresight.condition_number;
  figures["residual_initial_m"] = calibration.adjustment.residual_initial_m;
  figures["residual_final_m"] = calibration.adjustment.residual_final_m;
  for (const char* key : {"nodes", "imu_epochs", "gnss_epochs"}) figures[key] = nullptr;
  json.update(compared);
  json["model_check"] = ModelCheckJson(check);
  json["timing_s"] = TimingJson(timings);
  return json;
}

}  // namespace dn::diagnosis_internal
