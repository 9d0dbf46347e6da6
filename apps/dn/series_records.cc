#include "series_records.h"

#include <dn/geo/read_file.h>
#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace dn::apps {
namespace {

constexpr std::size_t kMostYaml = kMaxYamlBytes;

void ExpectNumber(const JsonPlace& record, const char* key, std::uint64_t expected) {
  const JsonPlace place = record.At(key);
  const std::uint64_t value = place.Unsigned();
  if (value != expected) {
    place.Fail(fmt::format("is {}, not {} as the name of the file says", value, expected));
  }
}

/// Returns the names of the scenarios from which blind flights are made.
std::vector<std::string> ScenarioNamesIn(const JsonPlace& scenarios) {
  std::vector<std::string> names;
  for (const JsonPlace& scenario : scenarios.Elements()) {
    const bool is_file = scenario.json().is_object() && scenario.json().size() == 1;
    names.push_back(is_file ? scenario.json().begin().key() : scenario.Text());
  }
  return names;
}

/// Returns the labels of every key of a sweep.
std::vector<std::vector<std::string>> LabelsIn(const JsonPlace& made_from) {
  const JsonPlace place = made_from.At("labels");
  std::vector<std::vector<std::string>> labels;
  for (const JsonPlace& key : place.Elements()) {
    labels.push_back(ReadTexts(key));
    if (labels.back().empty()) key.Fail("is empty");
  }
  if (labels.size() != ReadTexts(made_from.At("keys")).size()) {
    place.Fail("must have one list per key");
  }
  return labels;
}

/// Returns the labels of design `number`, which counts from 1; the last key changes fastest.
std::vector<std::string> DesignLabels(const std::vector<std::vector<std::string>>& labels,
                                      std::uint64_t number) {
  std::vector<std::string> chosen;
  std::uint64_t rest = number - 1;
  for (auto key = labels.rbegin(); key != labels.rend(); ++key) {
    chosen.push_back((*key)[rest % key->size()]);
    rest /= key->size();
  }
  std::reverse(chosen.begin(), chosen.end());
  return chosen;
}

}  // namespace

RecordReader<FlightRecord> FlightRecordReader(const JsonPlace& made_from) {
  made_from.At("scenario").Text(kMostYaml);
  const bool with_pairs = made_from.At("with_pairs").Flag();
  return [with_pairs](const JsonPlace& json, std::uint64_t number) {
    ExpectNumber(json, "seed", number);
    FlightRecord record = FlightRecordFromJson(json);
    if (record.with_pairs != with_pairs) {
      json.At("with_pairs").Fail("differs from made_from.json");
    }
    return record;
  };
}

RecordReader<BlindRecord> BlindRecordReader(const JsonPlace& made_from) {
  const std::uint64_t seed = made_from.At("seed").Unsigned();
  const std::vector<std::string> names = ScenarioNamesIn(made_from.At("scenarios"));
  const std::string only = made_from.At("only").Text();
  return [=](const JsonPlace& json, std::uint64_t number) {
    ExpectNumber(json, "number", number);
    BlindRecord record = BlindRecordFromJson(json);
    ExpectNumber(json, "seed", BlindFlightSeed(seed, record.number));
    if (std::find(names.begin(), names.end(), record.base) == names.end()) {
      json.At("base").Fail("is not a scenario of made_from.json");
    }
    if (!only.empty() && only != Word(record.content)) {
      json.At("content").Fail("differs from made_from.json");
    }
    return record;
  };
}

RecordReader<SweepRecord> SweepRecordReader(const JsonPlace& made_from) {
  made_from.At("sweep").Text(kMostYaml);
  made_from.At("base").Text(kMostYaml);
  auto labels = LabelsIn(made_from);
  return [labels = std::move(labels)](const JsonPlace& json, std::uint64_t number) {
    ExpectNumber(json, "number", number);
    SweepRecord record = SweepRecordFromJson(json);
    if (record.labels != DesignLabels(labels, number)) {
      json.At("labels").Fail("differ from the labels of this design in made_from.json");
    }
    return record;
  };
}

void ExpectAllDesigns(const JsonPlace& made_from, const Series& series) {
  std::uint64_t designs = 1;
  for (const std::vector<std::string>& key : LabelsIn(made_from)) {
    designs = std::min<std::uint64_t>(designs * key.size(), kMostFlights + 1);
  }
  if (designs == series.flights) return;
  made_from.At("labels").Fail(
      fmt::format("does not give the {} designs of report.json", series.flights));
}

}  // namespace dn::apps
