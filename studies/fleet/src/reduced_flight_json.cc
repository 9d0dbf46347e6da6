#include <dn/adjustment/words.h>
#include <dn/error.h>
#include <dn/fleet/reduced_flight.h>

#include <cmath>
#include <limits>

#include "reduced_numbers.h"

namespace dn {
namespace {

using Eigen::Index;

constexpr const char* kSchema = "dn.reduced/1";
constexpr std::size_t kMostUnknowns = 1000, kMostReasons = 10'000;
using fleet_internal::kLargestNumber;

Json MountingJson(const FlightMounting& mounting) {
  return {{"body_from_scanner", ToJsonMatrix(mounting.R_bs_nominal)},
          {"body_from_imu", ToJsonMatrix(mounting.R_imu_to_body)},
          {"lidar_lever_arm_m", ToJson(mounting.lidar_lever_arm_b_m)},
          {"scan_axis", ToJson(mounting.scan_axis_s)},
          {"nadir_axis", ToJson(mounting.nadir_axis_s)},
          {"gnss_lever_arm_m", ToJson(mounting.gnss_lever_arm_b_m)}};
}

FlightMounting ReadMounting(const JsonPlace& json) {
  return {ReadMatrix3(json.At("body_from_scanner")),
          ReadMatrix3(json.At("body_from_imu")),
          ReadFiniteVector3(json.At("lidar_lever_arm_m")),
          ReadFiniteVector3(json.At("scan_axis")),
          ReadFiniteVector3(json.At("nadir_axis")),
          ReadFiniteVector3(json.At("gnss_lever_arm_m"))};
}

Eigen::VectorXd ReadVector(const JsonPlace& list) {
  const std::vector<JsonPlace> elements = list.Elements(kMostUnknowns);
  Eigen::VectorXd vector(static_cast<Index>(elements.size()));
  for (std::size_t k = 0; k < elements.size(); ++k) {
    vector[static_cast<Index>(k)] = fleet_internal::ReadNumber(elements[k]);
  }
  return vector;
}

Eigen::MatrixXd ReadCovariance(const JsonPlace& rows, Index size) {
  const std::vector<JsonPlace> elements = rows.Elements(kMostUnknowns);
  if (static_cast<Index>(elements.size()) != size) rows.Fail("must have one row per unknown");
  Eigen::MatrixXd C(size, size);
  for (Index r = 0; r < size; ++r) {
    const JsonPlace& row = elements[static_cast<std::size_t>(r)];
    const Eigen::VectorXd values = ReadVector(row);
    if (values.size() != size) row.Fail("must have one number per unknown");
    C.row(r) = values.transpose();
  }
  fleet_internal::ExpectCovariance(C, rows);
  return C;
}

Json EffectJson(const ReducedEffect& effect) {
  return {{"effect", EffectName(effect.effect)},
          {"estimated", effect.estimated},
          {"components", effect.components},
          {"prior_sigma", ToJson(effect.prior_sigma)},  // null: without a prior
          {"remedy", effect.remedy}};
}

ReducedEffect ReadEffect(const JsonPlace& json) {
  const EffectSpec* row = FindEffect(json.At("effect").Text());
  if (row == nullptr || !row->fixed()) json.At("effect").Fail("is not the name of a fixed effect");
  ReducedEffect effect{row->id, json.At("estimated").Flag(), {}, {}, json.At("remedy").Text()};
  const auto most = static_cast<std::int64_t>(row->components.size()) - 1;
  for (const JsonPlace& one : json.At("components").Elements(kMostUnknowns)) {
    effect.components.push_back(one.Integer(0, most));
  }
  const std::vector<JsonPlace> sigmas = json.At("prior_sigma").Elements(kMostUnknowns);
  if (sigmas.size() != effect.components.size()) {
    json.At("prior_sigma").Fail("must have one number per component");
  }
  effect.prior_sigma.resize(static_cast<Index>(sigmas.size()));
  for (std::size_t k = 0; k < sigmas.size(); ++k) {
    effect.prior_sigma[static_cast<Index>(k)] =
        sigmas[k].is_null() ? std::numeric_limits<double>::infinity()
                            : sigmas[k].Number(std::numeric_limits<double>::min(), kLargestNumber);
  }
  return effect;
}

Verdict ReadVerdict(const JsonPlace& place) {
  for (const Verdict verdict : {Verdict::kCalibrated, Verdict::kAbsorbed, Verdict::kNotObservable,
                                Verdict::kContradicted}) {
    if (place.Text() == Word(verdict)) return verdict;
  }
  place.Fail("is not a verdict");
}

Json OptionalJson(const std::optional<Eigen::Vector3d>& vector) {
  return vector ? ToJson(*vector) : Json(nullptr);
}

std::optional<Eigen::Vector3d> ReadOptional(const JsonPlace& place) {
  if (place.is_null()) return std::nullopt;
  return ReadFiniteVector3(place);
}

}  // namespace

Json ReducedFlightJson(const ReducedFlight& flight) {
  Json effects = Json::array();
  for (const ReducedEffect& effect : flight.effects) effects.push_back(EffectJson(effect));
  Json json = {{"schema", kSchema},
               {"flight", flight.name},
               {"made_from", flight.made_from},
               {"data", flight.data},
               {"begin_s", flight.begin_s},
               {"end_s", flight.end_s},
               {"origin_rad_m", {flight.origin.lat_rad, flight.origin.lon_rad, flight.origin.h_m}},
               {"mounting", MountingJson(flight.mounting)},
               {"verdict", Word(flight.verdict)},
               {"reasons", flight.reasons},
               {"angles_rad", ToJson(flight.angles_rad)},
               {"as_modelled",
                {{"angles_rad", ToJson(flight.as_modelled.angles_rad)},
                 {"covariance_rad2", ToJsonMatrix(flight.as_modelled.covariance_rad2)}}},
               {"prior_angles_rad", OptionalJson(flight.prior_angles_rad)},
               {"prior_sigma_rad", OptionalJson(flight.prior_sigma_rad)},
               {"effects", effects},
               {"mean", ToJson(flight.mean)},
               {"covariance", ToJsonMatrix(flight.covariance)}};
  if (flight.ties) json["ties"] = ReducedTiesJson(*flight.ties);
  return json;
}

ReducedFlight ReadReducedFlight(const JsonPlace& json) {
  if (json.At("schema").Text() != kSchema) json.At("schema").Fail("must be dn.reduced/1");
  ReducedFlight flight;
  flight.name = json.At("flight").Text();
  flight.made_from = json.At("made_from").Text();
  flight.data = json.At("data").Text();
  flight.begin_s = json.At("begin_s").Number();
  flight.end_s = json.At("end_s").Number();
  const Eigen::Vector3d origin = ReadFiniteVector3(json.At("origin_rad_m"));
  flight.origin = {origin.x(), origin.y(), origin.z()};
  flight.mounting = ReadMounting(json.At("mounting"));
  flight.verdict = ReadVerdict(json.At("verdict"));
  for (const JsonPlace& reason : json.At("reasons").Elements(kMostReasons)) {
    flight.reasons.push_back(reason.Text());
  }
  flight.angles_rad = ReadFiniteVector3(json.At("angles_rad"));
  const JsonPlace modelled = json.At("as_modelled");
  flight.as_modelled = {ReadFiniteVector3(modelled.At("angles_rad")),
                        ReadCovariance(modelled.At("covariance_rad2"), 3)};
  flight.prior_angles_rad = ReadOptional(json.At("prior_angles_rad"));
  flight.prior_sigma_rad = ReadOptional(json.At("prior_sigma_rad"));
  Index size = 3;
  for (const JsonPlace& effect : json.At("effects").Elements(kMostUnknowns)) {
    flight.effects.push_back(ReadEffect(effect));
    size += flight.effects.back().prior_sigma.size();
  }
  flight.mean = ReadVector(json.At("mean"));
  if (flight.mean.size() != size) json.At("mean").Fail("must have one number per unknown");
  flight.covariance = ReadCovariance(json.At("covariance"), size);
  if (json.Has("ties")) flight.ties = ReadReducedTies(json.At("ties"), size);
  return flight;
}

}  // namespace dn
