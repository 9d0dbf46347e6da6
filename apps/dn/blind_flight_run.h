#pragma once

#include <dn/montecarlo/blind_record.h>

#include <filesystem>
#include <string>
#include <vector>

namespace dn::apps {

/// Where the flights of a blind check lie, and how they are diagnosed.
struct BlindRunOptions {
  std::filesystem::path out;
  std::vector<std::string> gap_options;  ///< of `dn gap`, beside the flight and --out
  bool discard_flights = false;          ///< remove the folder of a flight that is recorded
};

/// Writes a drawn flight to OUT/flights/NNN and its truth to OUT/truth/NNN.yaml, lets `dn gap` and
/// `dn calibrate` run on its folder as programs of their own, and then `dn calibrate` on the
/// adapted flight where the diagnosis has made one. Their results stay in OUT/runs/NNN. What they
/// refuse, and a flight that cannot be flown, becomes the record's failure. Throws Interrupted, and
/// for what cannot be written or started.
BlindRecord RunBlindFlight(const BlindFlight& flight, const BlindRunOptions& options);

}  // namespace dn::apps
