#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dn::testing {

/// Letters of the readers. The first byte of an input is such a letter and selects the reader;
/// letters keep the corpus readable.
///
///   T ReadTextTable                     S ReadTrajectory, SBET      O ReadTrajectory, ODyN text
///   I ReadImu, ODyN                     J ReadImu, increments
///   G ReadGnss, ODyN                    R ReadGnss, RTKLIB          B ReadGnss, OB_GINS
///   N ReadGnss, NMEA
///   P ReadPairs                         F ReadFlightConfig          C ParseScenario
///   V ReadTrajectoryCovariance          L OpenStrip, LAS            X OpenStrip, text
///   M ParseJson                         D FlightRecordFromJson      W SweepRecordFromJson
///   E BlindRecordFromJson               H ReadSurfacePairs
inline constexpr std::string_view kReaders = "TSOIJGRBNPFCVLXMDWEH";

/// Gives the bytes after the first one to a reader, as a file in memory. The first byte selects the
/// reader: by its letter, or modulo the number of readers if it is not in kReaders.
///
/// Returns the message of the InvalidInput that the reader threw, or an empty string if it accepted
/// the input. Aborts, for every build type, if an accepted input violates the reader's guarantees
/// (finite values, increasing times, a configuration that reads back). Also aborts if a rejection
/// has no message. Any other exception of the reader passes through.
std::string ReadAnything(const unsigned char* data, std::size_t size);

}  // namespace dn::testing
