#include <dn/study/sweep.h>

namespace dn {

Json ToJson(const SweepRecord& record) {
  return {{"number", record.number},
          {"labels", record.labels},
          {"failure", record.failure},
          {"sigma_rad", ToJson(record.sigma_rad)},
          {"condition_number", record.condition_number},
          {"correlation_angles", record.correlation_angles},
          {"correlation_biases", record.correlation_biases},
          {"roll_pitch_rad", record.strips.roll_pitch_rad},
          {"yaw_rad", record.strips.yaw_rad},
          {"position_m", record.strips.position_m}};
}

SweepRecord SweepRecordFromJson(const Json& json) {
  SweepRecord record;
  record.number = json.at("number").get<std::uint64_t>();
  record.labels = json.at("labels").get<std::vector<std::string>>();
  record.failure = json.at("failure").get<std::string>();
  for (std::size_t i = 0; i < 3; ++i) {
    record.sigma_rad[static_cast<Eigen::Index>(i)] = json.at("sigma_rad").at(i).get<double>();
  }
  record.condition_number = json.at("condition_number").get<double>();
  record.correlation_angles = json.at("correlation_angles").get<double>();
  record.correlation_biases = json.at("correlation_biases").get<double>();
  record.strips = {json.at("roll_pitch_rad").get<double>(), json.at("yaw_rad").get<double>(),
                   json.at("position_m").get<double>()};
  return record;
}

}  // namespace dn
