#pragma once

#include <dn/builder/flight_network.h>
#include <dn/diagnosis/diagnose.h>
#include <dn/effects/effect_table.h>
#include <dn/solvers/linearized_network.h>

#include <string>
#include <vector>

#include "hypothesis.h"
#include "time_cells.h"

namespace dn::diagnosis_internal {

/// The effects to be tested.
struct LibraryOptions {
  std::vector<std::string> effects;   ///< only these; empty: all
  std::vector<std::string> left_out;  ///< all but these
  int threads = 1;

  bool Wanted(const std::string& effect) const;
  bool Wanted(EffectId effect) const { return Wanted(EffectName(effect)); }
};

/// Returns the options of the library of a diagnosis.
LibraryOptions MakeLibraryOptions(const GapOptions& options);

/// Makes the library of a flight: all fixed effects with their possible windows and starts,
/// processes expressed by cosines, and unmodelled discrepancies.
Library MakeLibrary(const FlightNetwork& network, const LinearizedNetwork& linearized,
                    const LibraryOptions& options);

/// Adds a boresight step for each start of a cell but the first, if wanted, and then the
/// discrepancy BoresightByCell itself.
void AddBoresightTimes(Hypothesis by_cell, EffectModel columns, const TimeCells& cells,
                       const LibraryOptions& options, Library* library);

/// Adds a decaying discrepancy for each time constant of the columns of BoresightSettling.
void AddSettling(const Hypothesis& settling, EffectModel columns, const std::vector<double>& taus_s,
                 Library* library);

}  // namespace dn::diagnosis_internal
