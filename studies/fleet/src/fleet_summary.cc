#include <dn/adjustment/words.h>
#include <dn/axis_names.h>
#include <dn/diagnosis/result_files.h>
#include <dn/fleet/fleet.h>
#include <fmt/format.h>

#include <cmath>

#include "angle_text.h"

namespace dn {
namespace {

std::string CommonTable(const FleetResult& fleet) {
  const Eigen::Vector3d angles = fleet.boresight.angles_rad * kDegPerRad;
  const Eigen::Vector3d sigma = fleet.boresight.sigma_rad() * kDegPerRad;
  const Eigen::Vector3d shared =
      fleet.shared_covariance_rad2.diagonal().cwiseMax(0.0).cwiseSqrt() * kDegPerRad;
  std::string text = fmt::format(
      "boresight of {} flights{} [deg], rotation vector about the body axes\n"
      "  {:<6} {:>12} {:>12} {:>22}\n",
      fleet.flights.size(), fleet.constant ? "" : ", at the last one", "", "estimate", "sigma",
      "of it, shared effects");
  for (int i = 0; i < 3; ++i) {
    text += fmt::format("  {:<6} {:>12.6f} {:>12.6f} {:>22.6f}\n", kRollPitchYaw[i], angles[i],
                        sigma[i], shared[i]);
  }
  return text;
}

std::string FlightTable(const FleetResult& fleet) {
  std::string text =
      "flights: angles and sigmas of each alone, and its change against the others [deg]\n";
  for (const FleetFlight& flight : fleet.flights) {
    text += fmt::format(
        "  {:<16} {}; change {}, p = {:.2g}{}\n", flight.name,
        fleet_internal::AnglesWithSigma(flight.alone),
        fleet_internal::AnglesWithSigma(flight.change), flight.p_value,
        flight.verdict == Verdict::kCalibrated ? "" : fmt::format("; {}", Word(flight.verdict)));
  }
  return text;
}

std::string TiesTable(const FleetTies& ties) {
  std::string text = fmt::format(
      "pairs between flights: {} in use, variances times {:.2f}; mean difference of the ends by "
      "each flight alone [m], east, north, up\n",
      ties.used(), ties.noise_factor);
  for (const StripTies& strips : ties.by_strips) {
    text += fmt::format("  {}: {} of {} pairs;", strips.file, strips.used,
                        strips.used + strips.rejected);
    for (int i = 0; i < 3; ++i) {
      text += (i == 0 ? " " : ", ") + FormatWithSigma(strips.mean_enu_m[i], strips.sigma_enu_m[i]);
    }
    text += fmt::format("; p = {:.2g}\n", strips.p_value);
  }
  return text;
}

std::string ForecastLines(const FleetResult& fleet) {
  const BoresightWalk& walk = fleet.walk;
  std::string text = fmt::format(
      "next flight [deg]: {} if the boresight is constant\n"
      "  {} with a random walk of {:.6f} deg per flight, {}",
      fleet_internal::AnglesWithSigma(fleet.next_constant),
      fleet_internal::AnglesWithSigma(fleet.next_walk), walk.sigma_rad * kDegPerRad,
      walk.stated ? "as stated" : "as estimated");
  if (std::isfinite(walk.upper_rad)) {
    text += fmt::format(" (95 % below {:.6f})", walk.upper_rad * kDegPerRad);
  }
  return text + "\n";
}

}  // namespace

std::string FleetSummary(const FleetResult& fleet, const std::vector<ExcludedFlight>& excluded) {
  std::string text = CommonTable(fleet);
  for (const UnknownEstimate& unknown : fleet.unknowns) {
    text += fmt::format("{} [{}], correction to the assumed value:", unknown.name, unknown.unit);
    for (std::size_t i = 0; i < unknown.value.size(); ++i) {
      text += " " + FormatWithSigma(unknown.value[i], unknown.sigma[i]);
    }
    text += "\n";
  }
  text += FlightTable(fleet);
  for (const auto& [flight, reason] : excluded) {
    text += fmt::format("  {:<16} left out: {}\n", flight, reason);
  }
  if (fleet.ties) text += TiesTable(*fleet.ties);
  text += ForecastLines(fleet);
  text += fmt::format("assessment: {}\n", Word(fleet.boresight.verdict));
  for (const std::string& reason : FleetReasons(fleet)) text += "  " + reason + "\n";
  return text + ContributionsSummary(fleet.boresight);
}

}  // namespace dn
