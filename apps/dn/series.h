#pragma once

#include <dn/blind_check/blind_record.h>
#include <dn/montecarlo/flight_record.h>
#include <dn/report/json_reader.h>
#include <dn/study/sweep.h>

#include <cstdint>
#include <string>
#include <vector>

#include "command.h"

namespace dn::apps {

/// Part of a series that one run processes: shard i of N has every N-th flight, starting with the
/// i-th.
struct Shard {
  int index = 1;  ///< from 1
  int count = 1;
};

/// Accepts "i/N" with 1 <= i <= N.
CLI::Validator ShardText();

/// Parses a text that ShardText has accepted.
Shard ParseShard(const std::string& text);

/// Largest number of flights or designs of a series.
inline constexpr std::uint64_t kMostFlights = 1'000'000;

/// A series of numbered flights or designs, as report.json describes it for `dn merge`.
struct Series {
  std::string command;      ///< "monte-carlo", "blind-check", "study"
  std::uint64_t first = 1;  ///< number of the first flight
  std::uint64_t flights = 0;
  Shard shard = {};
  std::string made_from = {};  ///< hash of its made_from.json

  /// Returns the numbers of the shard's flights. Throws InvalidConfig if the shard is empty.
  std::vector<std::uint64_t> Numbers() const;
};

Json SeriesToJson(const Series& series);
/// Reads a series from report.json. Throws InvalidInput if the value does not describe a series.
Series SeriesFromJson(const JsonPlace& json);

/// Returns the name of the record folder of a command within --out.
std::string RecordFolderName(const std::string& command);

/// These functions evaluate the records of a series and stage the result files of the command.
/// made_from: scenario and options of the series.
void AddMonteCarloResults(const Json& made_from, const std::vector<FlightRecord>& records,
                          Run* run);
void AddBlindCheckResults(const Json& made_from, const std::vector<BlindRecord>& records, Run* run);
void AddSweepResults(const Json& made_from, const std::vector<SweepRecord>& records, Run* run);

}  // namespace dn::apps
