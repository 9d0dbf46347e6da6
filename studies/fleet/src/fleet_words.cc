#include <dn/adjustment/words.h>
#include <dn/fleet/fleet.h>
#include <fmt/format.h>

#include "angle_text.h"

namespace dn {
namespace {

std::string StabilitySentence(const FleetResult& fleet) {
  const BoresightStability& stability = fleet.stability;
  const FleetFlight& flight = fleet.flights[stability.change.flight];
  const std::string p =
      stability.p_value < 1e-4 ? "p < 1e-4" : fmt::format("p = {:.2g}", stability.p_value);
  if (stability.stable()) {
    return fmt::format("the boresight is {} in all {} flights ({} of the largest change)",
                       fleet.constant ? "the same" : "as steady as the random walk states",
                       fleet.flights.size(), p);
  }
  const std::string when =
      stability.change.single_flight
          ? fmt::format(
                "the boresight of flight {} (from t = {:.1f} s) differs from that of the "
                "flights before and after it",
                flight.name, flight.begin_s)
          : fmt::format(
                "the boresight changed before flight {} (from t = {:.1f} s), after flight "
                "{}",
                flight.name, flight.begin_s, fleet.flights[stability.change.flight - 1].name);
  return fmt::format("{}: by {} deg roll, pitch, yaw, {}; {}", when,
                     fleet_internal::AnglesWithSigma(stability.change.change), p,
                     stability.change.single_flight
                         ? "calibrate without this flight"
                         : "calibrate the flights before and from it on separately, or state a "
                           "random walk with --across");
}

std::string TiesSentence(const FleetTies& ties) {
  const StripTies& strips = *ties.Contradiction();
  return fmt::format(
      "flights {} and {} see the same ground {}, {}, {} m apart in east, north, up ({} pairs of "
      "{}, p < {:.2g}): check datum, GNSS and pairs of both",
      strips.flight_i, strips.flight_j,
      FormatWithSigma(strips.mean_enu_m[0], strips.sigma_enu_m[0]),
      FormatWithSigma(strips.mean_enu_m[1], strips.sigma_enu_m[1]),
      FormatWithSigma(strips.mean_enu_m[2], strips.sigma_enu_m[2]),
      strips.used > 0 ? strips.used : strips.rejected, strips.file, FleetTies::kLevel);
}

}  // namespace

std::vector<std::string> FleetReasons(const FleetResult& fleet) {
  std::vector<std::string> reasons;
  if (!fleet.stability.stable()) reasons.push_back(StabilitySentence(fleet));
  if (fleet.ties && fleet.ties->Contradiction() != nullptr) {
    reasons.push_back(TiesSentence(*fleet.ties));
  }
  for (const FleetFlight& flight : fleet.flights) {
    if (flight.verdict == Verdict::kCalibrated) continue;
    reasons.push_back(fmt::format("flight {} is {}", flight.name, Word(flight.verdict)));
  }
  for (const std::string& reason : Words(fleet.boresight.reasons)) reasons.push_back(reason);
  if (fleet.stability.stable()) reasons.push_back(StabilitySentence(fleet));
  return reasons;
}

}  // namespace dn
