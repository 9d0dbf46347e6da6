#include <dn/adjustment/words.h>
#include <dn/diagnosis/result_files.h>
#include <dn/fleet/fleet.h>
#include <fmt/format.h>

#include <cmath>

namespace dn {
namespace {

constexpr double kDeg2PerRad2 = kDegPerRad * kDegPerRad;

Json NumberOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json AnglesJson(const UncertainAngles& angles) {
  return {{"angles_deg", ToJson(angles.rad * kDegPerRad)},
          {"sigma_deg", ToJson(angles.sigma_rad() * kDegPerRad)},
          {"covariance_deg2", ToJsonMatrix(angles.covariance_rad2 * kDeg2PerRad2)}};
}

Json FlightJson(const FleetFlight& flight) {
  Json json = AnglesJson(flight.alone);
  json["flight"] = flight.name;
  json["t0_s"] = flight.begin_s;
  json["verdict"] = Word(flight.verdict);
  json["change_deg"] = ToJson(flight.change.rad * kDegPerRad);
  json["change_sigma_deg"] = ToJson(flight.change.sigma_rad() * kDegPerRad);
  json["change_p_value"] = flight.p_value;
  return json;
}

Json StabilityJson(const FleetResult& fleet) {
  const BoresightStability& stability = fleet.stability;
  const FleetFlight& flight = fleet.flights[stability.change.flight];
  Json change = AnglesJson(stability.change.change);
  change["flight"] = flight.name;
  change["t0_s"] = flight.begin_s;
  change["kind"] = stability.change.single_flight ? "single_flight" : "from_flight_on";
  change["chi2"] = stability.change.statistic;
  change["after"] = AnglesJson(stability.change.after);
  return {{"stable", stability.stable()},
          {"p_value", stability.p_value},
          {"level", BoresightStability::kLevel},
          {"likeliest_change", change},
          {"chi2", stability.chi2},
          {"dof", stability.dof},
          {"chi2_p_value", stability.chi2_p_value}};
}

Json ForecastJson(const FleetResult& fleet) {
  Json walk = AnglesJson(fleet.next_walk);
  walk["step_sigma_deg"] = fleet.walk.sigma_rad * kDegPerRad;
  walk["step_stated"] = fleet.walk.stated;
  walk["step_upper_limit_95_deg"] = NumberOrNull(fleet.walk.upper_rad * kDegPerRad);
  walk["log_likelihood_ratio"] = fleet.walk.stated ? Json(nullptr) : Json(fleet.walk.log_ratio);
  walk["sigma_at_upper_limit_deg"] = ToJson(fleet.next_limit.sigma_rad() * kDegPerRad);
  return {{"constant", AnglesJson(fleet.next_constant)}, {"random_walk", walk}};
}

Json TiesJson(const FleetTies& ties) {
  Json strips = Json::array();
  for (const StripTies& one : ties.by_strips) {
    strips.push_back({{"pairs", one.file},
                      {"flights", {one.flight_i, one.flight_j}},
                      {"used", one.used},
                      {"rejected", one.rejected},
                      {"mean_enu_m", ToJson(one.mean_enu_m)},
                      {"sigma_enu_m", ToJson(one.sigma_enu_m)},
                      {"p_value", one.p_value}});
  }
  return {{"used", ties.used()}, {"noise_factor", ties.noise_factor}, {"strips", strips}};
}

Json BoresightJson(const BoresightResult& boresight) {
  Json json = PredictedBoresightJson(boresight);
  json["angles_deg"] = ToJson(boresight.angles_rad * kDegPerRad);
  json["euler_zyx_deg"] = ToJson(boresight.euler_zyx_rad * kDegPerRad);
  json["as_modelled"]["angles_deg"] = ToJson(boresight.as_modelled->angles_rad * kDegPerRad);
  json["sigma_apriori_deg"] = json["sigma_scaled_deg"] = nullptr;
  return json;
}

Json FiguresJson(const FleetResult& fleet) {
  AdjustmentFigures figures;
  figures.chi2 = fleet.stability.chi2;
  figures.redundancy = fleet.stability.dof;
  figures.sigma0 = std::sqrt(figures.chi2 / static_cast<double>(figures.redundancy));
  figures.iterations = 1;
  figures.converged = true;
  Json json = AdjustmentJson(figures);
  json["condition_number"] = fleet.boresight.condition_number;
  for (const char* key :
       {"nodes", "parameters", "imu_epochs", "gnss_epochs", "correspondences", "outliers"}) {
    json[key] = nullptr;
  }
  return json;
}

}  // namespace

Json FleetJson(const FleetResult& fleet, const std::vector<ExcludedFlight>& excluded) {
  Json json;
  json["schema"] = "dn.result/1";
  json["flight"] = fmt::format("{} flights, {} to {}", fleet.flights.size(),
                               fleet.flights.front().name, fleet.flights.back().name);
  json["method"] = "dn";
  json["boresight"] = BoresightJson(fleet.boresight);
  const UncertainAngles shared{Eigen::Vector3d::Zero(), fleet.shared_covariance_rad2};
  json["boresight"]["shared_effects_sigma_deg"] = ToJson(shared.sigma_rad() * kDegPerRad);
  json["across"] = fleet.constant ? "constant" : "random_walk";
  json["assessment"] = {{"verdict", Word(fleet.boresight.verdict)},
                        {"reasons", FleetReasons(fleet)}};
  json["correlations"] = nullptr;
  json["estimates"] = UnknownsJson(fleet.unknowns);
  json["adjustment"] = FiguresJson(fleet);
  json["flights"] = Json::array();
  for (const FleetFlight& flight : fleet.flights) json["flights"].push_back(FlightJson(flight));
  json["excluded"] = Json::array();
  for (const auto& [flight, reason] : excluded) {
    json["excluded"].push_back({{"flight", flight}, {"reason", reason}});
  }
  if (fleet.ties) json["ties"] = TiesJson(*fleet.ties);
  json["stability"] = StabilityJson(fleet);
  json["forecast"] = ForecastJson(fleet);
  return json;
}

}  // namespace dn
