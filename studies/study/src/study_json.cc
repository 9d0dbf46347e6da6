#include <dn/diagnosis/beams_output.h>
#include <dn/diagnosis/result_files.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <dn/study/study_output.h>

#include <cmath>

namespace dn {
namespace {

const char* Word(DesignSource source) {
  switch (source) {
    case DesignSource::kScenario:
      return "scenario";
    case DesignSource::kTrajectory:
      return "trajectory";
    case DesignSource::kInitialGuess:
      return "initial guess";
    case DesignSource::kInsGnss:
      return "INS/GNSS solution";
  }
  return "";
}

const char* Word(RemedyKind kind) {
  switch (kind) {
    case RemedyKind::kCrossStrip:
      return "cross_strip";
    case RemedyKind::kOppositeStrip:
      return "opposite_strip";
    case RemedyKind::kOtherHeight:
      return "other_height";
    case RemedyKind::kOtherSpeed:
      return "other_speed";
    case RemedyKind::kMorePairs:
      return "more_pairs";
  }
  return "";
}

Json DirectionJson(const StudyResult& study, const StudyDirection& direction) {
  Json unknowns = Json::object();
  for (const auto& [name, weight] : direction.unknowns) unknowns[name] = weight;
  Json tried = Json::object();
  for (const TriedRemedy& remedy : direction.tried) tried[Word(remedy.kind)] = remedy.sigma;
  const auto remedy = direction.remedy();
  return {{"unknowns", unknowns},
          {"correlation", direction.correlation},
          {"sigma", direction.sigma},
          {"sigma_of", direction.leading},
          {"unit", direction.unit},
          {"cause", CauseWords(study, direction)},
          {"remedy", RemedyWords(study, direction)},
          {"sigma_after_remedy", remedy ? Json(remedy->sigma) : Json()},
          {"tried", tried}};
}

Json UnknownsJson(const std::vector<StudyUnknown>& unknowns) {
  Json json = Json::object();
  for (const StudyUnknown& unknown : unknowns) {
    json[unknown.name] = {
        {"components", unknown.components}, {"sigma", unknown.sigma}, {"unit", unknown.unit}};
  }
  return json;
}

Json StripsJson(const FlightGeometry& geometry) {
  Json strips = Json::array();
  for (const StripGeometry& strip : geometry.strips) {
    strips.push_back({{"name", strip.name},
                      {"course_deg", strip.course_rad * kDegPerRad},
                      {"speed_m_s", strip.speed_mps},
                      {"height_above_ground_m", strip.height_m}});
  }
  return strips;
}

}  // namespace

Json StudyJson(const StudyResult& study) {
  const BoresightResult& boresight = study.boresight;
  Json weak = Json::array();
  for (const StudyDirection& direction : study.weak) {
    weak.push_back(DirectionJson(study, direction));
  }
  Json json{{"schema", "dn.study/1"},
            {"flight", study.name},
            {"states_from", Word(study.source)},
            {"observable", study.observable()},
            {"reasons", UnobservableWords(study)},
            {"boresight", PredictedBoresightJson(boresight)},
            {"condition_number", boresight.condition_number},
            {"correlations",
             {{"boresight_to_accel_bias", CorrelationJson(boresight.accel_bias)},
              {"boresight_to_gyro_bias", CorrelationJson(boresight.gyro_bias)}}},
            {"estimates", UnknownsJson(study.unknowns)},
            {"trajectory_sigma",
             {{"rp_deg", study.strips.roll_pitch_rad * kDegPerRad},
              {"yaw_deg", study.strips.yaw_rad * kDegPerRad},
              {"position_m", study.strips.position_m}}},
            {"strips", StripsJson(study.geometry)},
            {"weak_directions", weak},
            {"network",
             {{"nodes", study.nodes},
              {"parameters", study.parameters},
              {"imu_epochs", study.imu_epochs},
              {"gnss_epochs", study.gnss_epochs},
              {"correspondences", study.pairs}}}};
  AddPredictedScannersJson(study.mountings, &json);
  AddBeamsJson(study.beams, false, &json);
  return json;
}

std::string FormatCorrelations(const std::vector<BiasCorrelationAt>& correlations) {
  std::string text =
      "# t [s]; roll, pitch, yaw with accelerometer x, y, z each; with gyro x, y, z each\n";
  for (const BiasCorrelationAt& at : correlations) {
    text += FormatDouble(at.t_s);
    for (const Eigen::Matrix3d& matrix : {at.accel, at.gyro}) {
      for (Eigen::Index k = 0; k < matrix.size(); ++k) {
        text += ", " + FormatDouble(matrix(k / 3, k % 3));
      }
    }
    text += '\n';
  }
  return text;
}

}  // namespace dn
