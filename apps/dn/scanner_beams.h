#pragma once

#include <dn/files/flight.h>
#include <dn/lidar/beam_ends.h>
#include <dn/report/json.h>

#include <string>
#include <vector>

namespace dn::apps {

/// The beams of a scanner: those that flight.yaml states and those that the pairs name.
struct ScannerBeams {
  std::string scanner;     ///< name in a list of scanners, else empty
  std::size_t stated = 0;  ///< number of beams in flight.yaml; 0: none
  BeamEnds ends;
};

/// Counts the ends of each beam. Scanners without beams in flight.yaml and in their pairs are left
/// out.
std::vector<ScannerBeams> CountScannerBeams(const Flight& flight);

/// Says how many beams measured pairs, and what calibrate does with them. One line.
std::string Words(const ScannerBeams& beams);

Json ToJson(const std::vector<ScannerBeams>& beams);

}  // namespace dn::apps
