#include <dn/diagnosis/result_files.h>

#include "result_json.h"

namespace dn {
namespace {

Json StripsJson(const PlaneAdjustment& adjustment, const std::vector<std::string>& strips) {
  Json json = Json::object();
  for (const auto& [pair, planes] : adjustment.planes_by_strips) {
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
                     const ModelCheck& check, const std::vector<std::string>& strips,
                     const RunTimings& timings) {
  Json json = diagnosis_internal::FixedTrajectoryJson(
      flight, "planes", calibration, check,
      {{"planes", PlanesJson(calibration, strips)}, {"strip_pairs", nullptr}}, timings);
  if (!calibration.unknowns.empty()) {
    json["estimates"] = UnknownsJson(calibration.unknowns);
  }
  return json;
}

}  // namespace dn
