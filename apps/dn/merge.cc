#include <dn/error.h>
#include <dn/names.h>
#include <fmt/format.h>

#include <map>

#include "command.h"
#include "series_records.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

struct MergeArguments {
  CommonOptions common;
  std::vector<std::string> folders;
};

fs::path ReportFile(const fs::path& folder) { return folder / "report.json"; }

/// Reads which series, or which shard of it, the run in a folder has processed.
Series ReadSeries(const fs::path& folder) {
  const fs::path file = ReportFile(folder);
  const Json report = RecordFolder::IsThere(file) ? ReadJsonFile(file) : Json();
  const JsonPlace place(report, file.string());
  if (!place.Has("series")) {
    throw InvalidInput(
        "it is not the report of a finished run of dn monte-carlo, dn blind-check or dn study "
        "--sweep",
        {file.string()});
  }
  return SeriesFromJson(place.At("series"));
}

bool SameSeries(const Series& a, const Series& b) {
  return a.command == b.command && a.first == b.first && a.flights == b.flights;
}

/// The shards of one series with the record file of each flight.
struct Shards {
  Series series;  ///< the whole series
  Json made_from;
  std::string made_from_file;
  std::map<std::uint64_t, fs::path> records;
};

void ExpectSame(const Shards& shards, const Series& series, const Json& made_from,
                const std::string& folder) {
  if (SameSeries(shards.series, series) && shards.made_from == made_from) return;
  throw InvalidConfig(folder +
                      " is not a shard of the series in the first folder: its command, flights, "
                      "seed, options or version differ (report.json, made_from.json)");
}

void Add(const Series& shard, const fs::path& folder, Shards* shards) {
  for (const std::uint64_t number : shard.Numbers()) {
    const fs::path file = RecordFolder::RecordFile(folder, number);
    if (!RecordFolder::IsThere(file)) throw InvalidInput("the record is missing", {file.string()});
    if (!shards->records.emplace(number, file).second) {
      throw InvalidConfig(fmt::format("flight {} is in two of the folders: {} and {}", number,
                                      shards->records.at(number).string(), file.string()));
    }
  }
}

void ExpectComplete(const Shards& shards) {
  std::vector<std::string> missing;
  for (const std::uint64_t number : shards.series.Numbers()) {
    if (!shards.records.contains(number)) missing.push_back(std::to_string(number));
  }
  if (missing.empty()) return;
  constexpr std::size_t kShown = 10;
  const std::size_t count = missing.size();
  missing.resize(std::min(count, kShown));
  throw InvalidConfig(fmt::format("{} of {} flights are missing, such as {}; give all shards",
                                  count, shards.series.flights, JoinNames(missing)));
}

void ExpectOneRun(const Series& series, const Json& made_from, const std::string& folder) {
  if (RecordFolder::MadeFromHash(made_from) == series.made_from) return;
  throw InvalidInput("report.json and made_from.json are not of one run; run the command again",
                     {ReportFile(folder).string()});
}

Shards Gather(const std::vector<std::string>& folders) {
  Shards shards;
  for (const std::string& folder : folders) {
    const Series series = ReadSeries(folder);
    const fs::path records = fs::path(folder) / RecordFolderName(series.command);
    const Json made_from = RecordFolder::MadeFrom(records);
    ExpectOneRun(series, made_from, folder);
    if (shards.records.empty()) {
      shards.series = {series.command, series.first, series.flights, {}, series.made_from};
      shards.made_from = made_from;
      shards.made_from_file = RecordFolder::MadeFromFile(records).string();
    }
    ExpectSame(shards, series, made_from, folder);
    Add(series, records, &shards);
  }
  ExpectComplete(shards);
  return shards;
}

/// Reads all records in the order of their numbers, and then copies them to `folder`.
template <class Record>
std::vector<Record> Records(const Shards& shards, const fs::path& folder,
                            const RecordReader<Record>& reader) {
  const auto expect_no_signal = [] {
    if (SignalReceived()) throw dn::Interrupted();
  };
  std::vector<Record> records;
  for (const auto& [number, file] : shards.records) {
    expect_no_signal();
    records.push_back(RecordFolder::ReadFile(file, number, shards.series.made_from, reader));
  }
  const RecordFolder merged(folder, shards.made_from);
  std::size_t k = 0;
  for (const auto& [number, file] : shards.records) {
    expect_no_signal();
    merged.Write(number, ToJson(records[k++]));
  }
  return records;
}

/// Returns the list of inputs in the report of a shard.
Json ShardInputs(const fs::path& folder) {
  const fs::path file = ReportFile(folder);
  const Json report = ReadJsonFile(file);
  const JsonPlace place(report, file.string());
  return place.Has("inputs") ? place.At("inputs").json() : Json::array();
}

void Merge(const MergeArguments& options, Run& run) {
  const Shards shards = Gather(options.folders);
  const std::string& command = shards.series.command;
  const JsonPlace made_from(shards.made_from, shards.made_from_file);
  run.progress().Stage("merging", fmt::format("{} flights", shards.series.flights));
  const fs::path folder = options.common.out / RecordFolderName(command);
  run.report()["series"] = SeriesToJson(shards.series);
  run.report()["inputs"] = ShardInputs(options.folders.front());
  if (command == "monte-carlo") {
    const auto reader = FlightRecordReader(made_from);
    AddMonteCarloResults(shards.made_from, Records(shards, folder, reader), &run);
  } else if (command == "study") {
    const auto reader = SweepRecordReader(made_from);
    ExpectAllDesigns(made_from, shards.series);
    AddSweepResults(shards.made_from, Records(shards, folder, reader), &run);
  } else {
    const auto reader = BlindRecordReader(made_from);
    AddBlindCheckResults(shards.made_from, Records(shards, folder, reader), &run);
  }
}

}  // namespace

void AddMerge(CLI::App* program, Action* action) {
  auto options = std::make_shared<MergeArguments>();
  CLI::App* app = program->add_subcommand("merge",
                                          "Joins the shards of dn monte-carlo, dn blind-check or "
                                          "dn study --sweep into the result of a single run");
  app->add_option("DIR", options->folders, "Result folders of all shards")->required();
  AddCommonOptions(app, &options->common, true);
  app->footer(
      "Run the same command once per shard, e.g. with --shard 1/2 and --shard 2/2, each with its "
      "own\n"
      "--out, on any machine.\n"
      "Example: dn merge one two --out both");
  app->callback([options, action] {
    *action = [options] {
      for (const std::string& folder : options->folders) {
        options->common.inputs.folders.emplace_back(folder);
      }
      return Execute("merge", options->common, [&](Run& run) { Merge(*options, run); });
    };
  });
}

}  // namespace dn::apps
