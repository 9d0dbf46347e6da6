#pragma once

#include <dn/files/flight.h>
#include <dn/sim/simulate.h>

#include "testing/temp_folder.h"

namespace dn::sim_test {

/// Writes a simulated flight and reads its pairs back.
inline Flight WrittenAndRead(const SimulatedFlight& sim) {
  const testing::TempFolder folder;
  OutputDirectory directory(folder.path() / "flight");
  WriteFlight(sim, directory);
  directory.Commit();
  return ReadFlight(folder.path() / "flight", {.pairs = true});
}

}  // namespace dn::sim_test
