#include "study_sweep.h"

#include <dn/files/flight.h>
#include <dn/interrupted.h>
#include <dn/report/plot.h>
#include <dn/study/sweep.h>
#include <fmt/format.h>

#include <optional>
#include <vector>

#include "config_text.h"
#include "fleet.h"
#include "series_records.h"
#include "sha256.h"

namespace dn::apps {
namespace {

std::vector<SweepRecord> StudyAll(const Sweep& sweep, const RecordFolder& folder,
                                  const RecordReader<SweepRecord>& reader,
                                  const std::vector<std::uint64_t>& numbers, Run* run) {
  DesignOptions design;
  design.interrupted = [] { return SignalReceived(); };
  std::vector<SweepRecord> records(numbers.size());
  const auto study = [&](std::size_t k) {
    std::optional<SweepRecord> record = folder.Read(numbers[k], reader);
    if (!record) {
      record = StudySweepDesign(sweep, numbers[k], design);
      folder.Write(numbers[k], ToJson(*record));
    }
    records[k] = std::move(*record);
  };
  const auto studied = [&](std::size_t k) {
    if (records[k].failure.empty()) return;
    run->progress().Warn(fmt::format("design {}: {}", numbers[k], records[k].failure));
  };
  SimulateAll(numbers.size(), run, study, studied, "designs");
  return records;
}

Json PathsJson(const Sweep& sweep) {
  Json paths = Json::array();
  for (const SweepKey& key : sweep.keys()) paths.push_back(key.path);
  return paths;
}

/// Returns the labels of the values of each key.
Json LabelsJson(const Sweep& sweep) {
  Json labels = Json::array();
  for (const SweepKey& key : sweep.keys()) {
    Json of_key = Json::array();
    for (const SweepValue& value : key.values) of_key.push_back(value.label);
    labels.push_back(std::move(of_key));
  }
  return labels;
}

long CountSingular(const std::vector<SweepRecord>& records) {
  long singular = 0;
  for (const SweepRecord& record : records) singular += record.failure.empty() ? 0 : 1;
  return singular;
}

}  // namespace

void RunSweep(const SweepOptions& options, Run& run) {
  const std::string text = ReadConfigText(options.file);
  const Sweep sweep = Sweep::Parse(text, options.file);
  const Json made_from = {{"sweep", text},
                          {"base", sweep.base_text()},
                          {"keys", PathsJson(sweep)},
                          {"labels", LabelsJson(sweep)},
                          {"version", DN_VERSION},
                          {"program", ProgramHash()}};
  const Series series{"study", 1, sweep.size(), ParseShard(options.shard),
                      RecordFolder::MadeFromHash(made_from)};
  const RecordFolder folder(run.options().out / RecordFolderName(series.command), made_from);
  const std::vector<SweepRecord> records =
      StudyAll(sweep, folder, SweepRecordReader(made_from), series.Numbers(), &run);
  run.report()["series"] = SeriesToJson(series);
  AddSweepResults(made_from, records, &run);
}

void AddSweepResults(const Json& made_from, const std::vector<SweepRecord>& records, Run* run) {
  const std::vector<std::string> paths = made_from.at("keys").get<std::vector<std::string>>();
  run->report()["counts"] = {{"designs", records.size()}, {"singular", CountSingular(records)}};
  run->AddFile("config.resolved.yaml", made_from.at("sweep").get<std::string>());
  run->AddFile("base.yaml", made_from.at("base").get<std::string>());
  run->AddFile("sweep.csv", SweepCsv(paths, records));
  run->AddFile("sweep.json", FormatJson(SweepJson(paths, records)));
  const std::string table = SweepTable(paths, records);
  run->AddFile("summary.txt", table);
  for (const StudyPlot& plot : SweepPlots(paths, records)) {
    const auto svg = DrawSvg(plot.title, plot.x_label, plot.panels, SignalReceived);
    if (!svg) {
      run->progress().Warn(
          "no plots: gnuplot is not installed or failed; sweep.csv has the numbers");
      break;
    }
    run->AddFile(plot.file, *svg);
  }
  fmt::print("{}", table);
}

}  // namespace dn::apps
