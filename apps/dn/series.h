#pragma once

#include <dn/montecarlo/blind_record.h>
#include <dn/montecarlo/flight_record.h>
#include <dn/study/sweep.h>

#include <cstdint>
#include <string>
#include <vector>

#include "command.h"

namespace dn::apps {

/// The part of a series of flights that one run flies: of N shards the i-th has every N-th flight,
/// from the i-th on.
struct Shard {
  int index = 1;  ///< from 1
  int count = 1;
};

/// "i/N" with 1 <= i <= N.
CLI::Validator ShardText();

/// Reads what ShardText has accepted.
Shard ParseShard(const std::string& text);

/// A series of numbered flights, or designs, as report.json tells it to `dn merge`.
struct Series {
  std::string command;      ///< "monte-carlo", "blind-check", "study"
  std::uint64_t first = 1;  ///< number of the first flight
  std::uint64_t flights = 0;
  Shard shard = {};

  /// Numbers of the flights of the shard. Throws InvalidConfig where it has none.
  std::vector<std::uint64_t> Numbers() const;
};

Json SeriesToJson(const Series& series);
/// Throws Json::exception for what is no series.
Series SeriesFromJson(const Json& json);

/// Where a command keeps its records in --out.
std::string RecordFolderName(const std::string& command);

/// Judges the records of flights that were made from `made_from`, and stages the result files.
void AddMonteCarloResults(const Json& made_from, const std::vector<FlightRecord>& records,
                          Run* run);
void AddBlindCheckResults(const Json& made_from, const std::vector<BlindRecord>& records, Run* run);
void AddSweepResults(const Json& made_from, const std::vector<SweepRecord>& records, Run* run);

}  // namespace dn::apps
