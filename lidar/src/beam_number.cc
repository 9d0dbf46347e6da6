#include "beam_number.h"

#include <dn/geo/text_table.h>
#include <dn/lidar/beam.h>

#include <cmath>
#include <string>

namespace dn::lidar_internal {
namespace {

int Checked(double value, int lowest, const char* words, const FileLocation& where) {
  if (value >= lowest && value < kMostBeams && value == std::floor(value)) {
    return static_cast<int>(value);
  }
  throw InvalidInput("beam " + FormatDouble(value) + " is not an integer from " + words + " to " +
                         std::to_string(kMostBeams - 1) +
                         ": number the beams of the scanner from 0",
                     where);
}

}  // namespace

std::uint16_t CheckedBeam(double value, const FileLocation& where) {
  return static_cast<std::uint16_t>(Checked(value, 0, "0", where));
}

int CheckedPairBeam(double value, const FileLocation& where) {
  return Checked(value, kNoBeam, "-1 (several beams)", where);
}

}  // namespace dn::lidar_internal
