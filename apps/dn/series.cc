#include "series.h"

#include <dn/error.h>
#include <fmt/format.h>

#include <charconv>
#include <limits>

#include "shown_text.h"

namespace dn::apps {
namespace {

/// Parses "i/N"; the returned index is 0 if the text is invalid.
Shard TryParse(const std::string& text) {
  constexpr int kMostShards = 1000000;
  const char* end = text.data() + text.size();
  Shard shard;
  const auto index = std::from_chars(text.data(), end, shard.index);
  if (index.ec != std::errc() || index.ptr == end || *index.ptr != '/') return {0, 1};
  const auto count = std::from_chars(index.ptr + 1, end, shard.count);
  const bool whole = count.ec == std::errc() && count.ptr == end;
  const bool inside = shard.index >= 1 && shard.index <= shard.count && shard.count <= kMostShards;
  return whole && inside ? shard : Shard{0, 1};
}

}  // namespace

CLI::Validator ShardText() {
  const auto check = [](const std::string& text) {
    if (TryParse(text).index > 0) return std::string();
    return Quoted(text) + " is not a shard i/N with 1 <= i <= N";
  };
  return {check, "i/N"};
}

Shard ParseShard(const std::string& text) { return TryParse(text); }

std::vector<std::uint64_t> Series::Numbers() const {
  std::vector<std::uint64_t> numbers;
  const auto step = static_cast<std::uint64_t>(shard.count);
  for (auto k = static_cast<std::uint64_t>(shard.index - 1); k < flights; k += step) {
    numbers.push_back(first + k);
  }
  if (!numbers.empty()) return numbers;
  throw InvalidConfig(fmt::format("shard {}/{} of {} flights is empty; give at most {} shards",
                                  shard.index, shard.count, flights, flights));
}

Json SeriesToJson(const Series& series) {
  return {{"command", series.command},
          {"first", series.first},
          {"flights", series.flights},
          {"shard", fmt::format("{}/{}", series.shard.index, series.shard.count)},
          {"made_from", series.made_from}};
}

Series SeriesFromJson(const JsonPlace& json) {
  Series series;
  series.command = json.At("command").Text();
  const bool is_monte_carlo = series.command == "monte-carlo";
  if (!is_monte_carlo && series.command != "blind-check" && series.command != "study") {
    json.At("command").Fail("is not a command that makes a series");
  }
  series.first = json.At("first").Unsigned();
  const bool fits = series.first <= std::numeric_limits<std::uint64_t>::max() - kMostFlights;
  if (!(is_monte_carlo ? fits : series.first == 1))
    json.At("first").Fail("is not a valid first number of this series");
  series.flights = static_cast<std::uint64_t>(json.At("flights").Integer(1, kMostFlights));
  series.shard = ParseShard(json.At("shard").Text());
  if (series.shard.index == 0) json.At("shard").Fail("is not a shard i/N");
  series.made_from = json.At("made_from").Text();
  return series;
}

std::string RecordFolderName(const std::string& command) {
  if (command == "study") return "designs";
  return command == "monte-carlo" ? "flights" : "records";
}

}  // namespace dn::apps
