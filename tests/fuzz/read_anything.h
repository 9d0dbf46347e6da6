#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace dn::testing {

/// Which reader gets the bytes: the first byte of an input, a letter, so that the corpus is
/// readable.
///
///   T ReadTextTable                     S ReadTrajectory, SBET      O ReadTrajectory, ODyN text
///   I ReadImu, ODyN                     J ReadImu, increments
///   G ReadGnss, ODyN                    R ReadGnss, RTKLIB          B ReadGnss, OB_GINS
///   N ReadGnss, NMEA
///   P ReadPairs                         F ReadFlightConfig          C ParseScenario
///   V ReadTrajectoryCovariance          L OpenStrip, LAS            X OpenStrip, text
///   M ParseJson                         D FlightRecordFromJson      W SweepRecordFromJson
///   E BlindRecordFromJson
inline constexpr std::string_view kReaders = "TSOIJGRBNPFCVLXMDWE";

/// Gives the bytes after the first to the reader that the first selects (any other letter: modulo
/// the number of readers), as a file in memory.
///
/// Returns the message of the InvalidInput that the reader threw, or an empty string when it
/// accepted the input. Aborts, for every build type, when an accepted input breaks what the reader
/// promises (finite values, increasing times, a configuration that reads back), or a rejection has
/// no message. Anything else that the reader throws passes through.
std::string ReadAnything(const unsigned char* data, std::size_t size);

}  // namespace dn::testing
