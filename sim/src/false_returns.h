#pragma once

#include <dn/sim/random.h>

#include <cstdint>
#include <vector>

#include "echoes.h"

namespace dn {

/// Return of a pulse as a file has it.
struct Return {
  double range_m = 0.0;
  std::uint16_t intensity = 0;
  std::uint8_t point_class = 0;  ///< LAS class
  std::uint8_t flags = 0;        ///< flags of StripCloud
};

/// Returns a detected echo as a file has it. The intensity is proportional to the energy and to the
/// inverse square of the range. height_m is the height over ground.
Return MakeReturn(const Echo& echo, double height_m);

/// Adds a return from nothing that should be in the data. Most come from birds or aerosol in the
/// air (class 18); the others are multipath, below the ground (class 7). Half of them are also
/// flagged as withheld. height_m is the range where the pulse has no other return.
void AddFalseReturn(double height_m, Random* random, std::vector<Return>* returns);

}  // namespace dn
