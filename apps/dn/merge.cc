#include <dn/error.h>
#include <dn/names.h>
#include <fmt/format.h>

#include <fstream>
#include <map>

#include "command.h"
#include "record_folder.h"
#include "series.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

struct MergeArguments {
  CommonOptions common;
  std::vector<std::string> folders;
};

fs::path ReportFile(const fs::path& folder) { return folder / "report.json"; }

Json ReportOf(const fs::path& folder) {
  std::ifstream in(ReportFile(folder), std::ios::binary);
  return Json::parse(in, nullptr, false);
}

/// Reads which series, or which shard of it, the run in a folder has processed.
Series ReadSeries(const fs::path& folder) {
  const fs::path file = ReportFile(folder);
  const Json report = ReportOf(folder);
  if (!report.is_object() || !report.contains("series")) {
    throw InvalidInput(
        "it tells of no finished run of dn monte-carlo, dn blind-check or dn study --sweep",
        {file.string()});
  }
  try {
    return SeriesFromJson(report.at("series"));
  } catch (const Json::exception& error) {
    throw InvalidInput(std::string("its 'series' is not one: ") + error.what(), {file.string()});
  }
}

bool SameSeries(const Series& a, const Series& b) {
  return a.command == b.command && a.first == b.first && a.flights == b.flights;
}

/// The shards of one series with the record file of each flight.
struct Shards {
  Series series;  ///< the whole series
  Json made_from;
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
    const fs::path file = RecordFolder::FileOf(folder, number);
    if (!fs::exists(file)) throw InvalidInput("the record is missing", {file.string()});
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

Shards Gather(const std::vector<std::string>& folders) {
  Shards shards;
  for (const std::string& folder : folders) {
    const Series series = ReadSeries(folder);
    const fs::path records = fs::path(folder) / RecordFolderName(series.command);
    const Json made_from = RecordFolder::MadeFrom(records);
    if (shards.records.empty()) {
      shards.series = {series.command, series.first, series.flights, {}};
      shards.made_from = made_from;
    }
    ExpectSame(shards, series, made_from, folder);
    Add(series, records, &shards);
  }
  ExpectComplete(shards);
  return shards;
}

/// Reads the records in the order of their numbers and copies each to the merged folder.
template <class Record, class Parse>
std::vector<Record> Records(const Shards& shards, const RecordFolder& merged, const Parse& parse) {
  std::vector<Record> records;
  for (const auto& [number, file] : shards.records) {
    if (SignalCame()) throw dn::Interrupted();
    records.push_back(RecordFolder::ReadFile(file, parse));
    merged.Write(number, ToJson(records.back()));
  }
  return records;
}

void Merge(const MergeArguments& options, Run& run) {
  const Shards shards = Gather(options.folders);
  const std::string& command = shards.series.command;
  run.progress.Stage("merging", fmt::format("{} flights", shards.series.flights));
  const RecordFolder merged(options.common.out / RecordFolderName(command), shards.made_from);
  run.report["series"] = SeriesToJson(shards.series);
  run.report["inputs"] = ReportOf(options.folders.front()).value("inputs", Json::array());
  if (command == "monte-carlo") {
    AddMonteCarloResults(shards.made_from,
                         Records<FlightRecord>(shards, merged, &FlightRecordFromJson), &run);
  } else if (command == "study") {
    AddSweepResults(shards.made_from, Records<SweepRecord>(shards, merged, &SweepRecordFromJson),
                    &run);
  } else {
    AddBlindCheckResults(shards.made_from,
                         Records<BlindRecord>(shards, merged, &BlindRecordFromJson), &run);
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
      "Make the shards with otherwise equal commands, e.g. with --shard 1/2 and --shard 2/2, each\n"
      "with its own --out, on any machine.\n"
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
