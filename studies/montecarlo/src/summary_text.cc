#include <dn/geo/text_table.h>
#include <dn/montecarlo/summary.h>
#include <fmt/format.h>

namespace dn {
namespace {

Json ToJson(const Interval& interval) { return Json::array({interval.low, interval.high}); }

Json ToJson(const TestedStatistic& figure) {
  return {{"value", figure.value}, {"band_99", ToJson(figure.band)}, {"ok", figure.ok()}};
}

Json ToJson(const std::vector<SensorConsistency>& sensors, bool white) {
  Json rows = Json::array();
  for (const SensorConsistency& sensor : sensors) {
    Json row = {{"sensor", sensor.sensor},
                {"axis", sensor.axis},
                {"variance_ratio", ToJson(sensor.variance_ratio)}};
    row["lag1_correlation"] = white ? ToJson(sensor.lag1) : Json(sensor.lag1.value);
    rows.push_back(row);
  }
  return rows;
}

Json ToJson(const TrajectoryConsistency& c) {
  return {{"quantity", c.quantity},
          {"nees_per_dof", c.mean_nees_per_dof},
          {"epochs", c.t_s.size()},
          {"epoch_band_99", ToJson(c.band)},
          {"share_of_epochs_outside", c.share_outside},
          {"share_of_epochs_above", c.share_above},
          {"rms_sigmas", dn::ToJson(c.rms_sigmas)}};
}

Json ToJson(const BoresightConsistency& b) {
  return {
      {"nees_per_dof", ToJson(b.nees_per_dof)},        {"coverage_1_sigma", ToJson(b.coverage[0])},
      {"coverage_2_sigma", ToJson(b.coverage[1])},     {"coverage_3_sigma", ToJson(b.coverage[2])},
      {"mean_sigmas", dn::ToJson(b.mean_sigmas)},      {"rms_deg", dn::ToJson(b.rms_deg)},
      {"mean_sigma_deg", dn::ToJson(b.mean_sigma_deg)}};
}

std::string Line(const std::string& name, const TestedStatistic& figure) {
  return fmt::format("  {:<34} {:>9.4f}  {:>8.4f} .. {:<8.4f} {}\n", name, figure.value,
                     figure.band.low, figure.band.high, figure.ok() ? "inside" : "OUTSIDE");
}

std::string SensorLines(const std::string& title, const std::vector<SensorConsistency>& sensors,
                        bool white) {
  std::string text = title;
  for (const SensorConsistency& s : sensors) {
    text += fmt::format("  {:<18} {:<12} {:>8.4f}  {:>7.4f} .. {:<7.4f} {:<8} lag-1 {:>7.4f} {}\n",
                        s.sensor, s.axis, s.variance_ratio.value, s.variance_ratio.band.low,
                        s.variance_ratio.band.high, s.variance_ratio.ok() ? "inside" : "OUTSIDE",
                        s.lag1.value,
                        !white        ? ""
                        : s.lag1.ok() ? "white"
                                      : "NOT WHITE");
  }
  return text;
}

}  // namespace

Json ToJson(const MonteCarloSummary& s) {
  Json json = {{"schema", "dn.monte_carlo/1"},
               {"flights", s.flights},
               {"failures", s.failure_messages},
               {"consistent", s.consistent()},
               {"boresight", s.with_pairs ? ToJson(s.boresight) : Json()},
               {"chi2_per_dof", ToJson(s.chi2_per_dof)},
               {"share_of_flights_with_chi2_inside", ToJson(s.share_chi2_inside)},
               {"share_of_flights_contradicted", ToJson(s.share_contradicted)},
               {"contradictions", s.contradictions},
               {"trajectory", Json::array()},
               {"position_rms_m", dn::ToJson(s.position_rms_m)},
               {"velocity_rms_mps", dn::ToJson(s.velocity_rms_mps)},
               {"attitude_rms_deg", dn::ToJson(s.attitude_rms_deg)},
               {"residuals", ToJson(s.residuals, false)},
               {"innovations", ToJson(s.innovations, true)}};
  for (const TrajectoryConsistency& c : s.trajectory) json["trajectory"].push_back(ToJson(c));
  return json;
}

std::string FormatTable(const MonteCarloSummary& s, const std::string& scenario) {
  std::string text =
      fmt::format("{} flights of {}, {} failed; 99 % bands for correct covariances\n", s.flights,
                  scenario, s.failures);
  for (const std::string& message : s.failure_messages) text += "  " + message + "\n";
  if (s.with_pairs) {
    text += Line("boresight NEES / 3", s.boresight.nees_per_dof);
    text += Line("boresight within 1 sigma", s.boresight.coverage[0]);
    text += Line("boresight within 2 sigma", s.boresight.coverage[1]);
    text += Line("boresight within 3 sigma", s.boresight.coverage[2]);
  }
  text += Line("2 x cost / redundancy", s.chi2_per_dof);
  text += Line("flights with 2 x cost in its band", s.share_chi2_inside);
  text += Line("flights with rejected model", s.share_contradicted);
  for (const std::string& message : s.contradictions) text += "    " + message + "\n";
  if (s.with_pairs) {
    const auto& b = s.boresight;
    text += fmt::format(
        "boresight roll, pitch, yaw: rms error {:.6f} {:.6f} {:.6f} deg, mean sigma {:.6f} {:.6f} "
        "{:.6f} deg, mean error {:.2f} {:.2f} {:.2f} sigma\n",
        b.rms_deg[0], b.rms_deg[1], b.rms_deg[2], b.mean_sigma_deg[0], b.mean_sigma_deg[1],
        b.mean_sigma_deg[2], b.mean_sigmas[0], b.mean_sigmas[1], b.mean_sigmas[2]);
  }
  text +=
      "trajectory at the nodes, NEES / 3 per epoch over the flights\n"
      "  quantity             mean    outside its band  above    rms of error / sigma\n";
  for (const TrajectoryConsistency& c : s.trajectory) {
    text += fmt::format("  {:<18} {:>7.4f}  {:>8.2f} %        {:>6.2f} %   {:.4f} {:.4f} {:.4f}\n",
                        c.quantity, c.mean_nees_per_dof, 100.0 * c.share_outside,
                        100.0 * c.share_above, c.rms_sigmas[0], c.rms_sigmas[1], c.rms_sigmas[2]);
  }
  text += fmt::format(
      "rms errors: position {:.4f} {:.4f} {:.4f} m (3D {:.4f}), velocity {:.4f} {:.4f} {:.4f} m/s, "
      "roll pitch heading {:.5f} {:.5f} {:.5f} deg\n",
      s.position_rms_m[0], s.position_rms_m[1], s.position_rms_m[2], s.position_rms_m.norm(),
      s.velocity_rms_mps[0], s.velocity_rms_mps[1], s.velocity_rms_mps[2], s.attitude_rms_deg[0],
      s.attitude_rms_deg[1], s.attitude_rms_deg[2]);
  text += SensorLines("residuals, mean square / expected\n", s.residuals, false);
  text += SensorLines("innovations, mean square / expected\n", s.innovations, true);
  return text;
}

std::string FormatTrajectoryNees(const MonteCarloSummary& summary) {
  std::string text;
  for (std::size_t q = 0; q < summary.trajectory.size(); ++q) {
    const TrajectoryConsistency& of = summary.trajectory[q];
    for (std::size_t k = 0; k < of.t_s.size(); ++k) {
      text += fmt::format("{}, {}, {}\n", q + 1, FormatDouble(of.t_s[k]),
                          FormatDouble(of.nees_per_dof[k]));
    }
  }
  return text.empty() ? text : "# number of the quantity, t [s], NEES / 3\n" + text;
}

std::string FormatBoresightErrors(const std::vector<FlightRecord>& records) {
  std::string text;
  for (const FlightRecord& record : records) {
    if (!record.failure.empty() || !record.with_pairs) continue;
    const Eigen::Vector3d sigmas = record.boresight_error_rad.cwiseQuotient(
        record.boresight_covariance_rad2.diagonal().cwiseSqrt());
    text += fmt::format("{}, {}, {}, {}\n", record.seed, FormatDouble(sigmas.x()),
                        FormatDouble(sigmas.y()), FormatDouble(sigmas.z()));
  }
  return text.empty() ? text : "# seed; error / sigma of roll, pitch, yaw\n" + text;
}

}  // namespace dn
