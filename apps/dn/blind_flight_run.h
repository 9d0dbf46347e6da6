#pragma once

#include <dn/blind_check/blind_record.h>

#include <filesystem>
#include <string>
#include <vector>

namespace dn::apps {

/// Output folder and diagnosis options of a blind check.
struct BlindRunOptions {
  std::filesystem::path out;
  std::vector<std::string> gap_options;  ///< extra options for `dn gap`
  bool discard_flights = false;          ///< delete the flight folder after recording
};

/// Simulates a randomly drawn flight, diagnoses and calibrates it, and returns the record. The
/// flight goes to OUT/flights/NNN and its truth to OUT/truth/NNN.yaml. `dn gap` and `dn calibrate`
/// run on the flight folder as separate processes. If the diagnosis writes an adapted flight,
/// `dn calibrate` also runs on that. Results stay in OUT/runs/NNN. A failed simulation or run is
/// stored as the record's failure. Throws Interrupted, and system errors if a file cannot be
/// written or a process cannot be started.
BlindRecord RunBlindFlight(const BlindFlight& flight, const BlindRunOptions& options);

}  // namespace dn::apps
