#pragma once

#include <dn/files/flight.h>
#include <dn/report/json.h>

#include <string>
#include <vector>

namespace dn::apps {

/// The beams that the pairs of a scanner name.
struct BeamEnds {
  std::string scanner;     ///< name in a list of scanners, else empty
  std::vector<long> ends;  ///< number of ends of pairs that each beam measured
  long without_beam = 0;   ///< number of other ends
  std::size_t stated = 0;  ///< number of beams in flight.yaml; 0: none

  /// Returns the number of beams that measured an end.
  std::size_t NumMeasured() const;
};

/// Counts the ends of each beam. Scanners without beams in flight.yaml and in their pairs are left
/// out.
std::vector<BeamEnds> CountBeamEnds(const Flight& flight);

/// Says how many beams measured pairs, and what calibrate does with them. One line.
std::string Words(const BeamEnds& beams);

Json ToJson(const std::vector<BeamEnds>& beams);

}  // namespace dn::apps
