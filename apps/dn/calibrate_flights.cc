#include "calibrate_flights.h"

#include <dn/adjustment/words.h>
#include <dn/error.h>
#include <dn/files/across.h>
#include <dn/files/flight_config.h>
#include <dn/files/scanners.h>
#include <dn/fleet/fleet.h>
#include <dn/fleet/reduced_flight.h>
#include <dn/stopwatch.h>
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "fleet_clouds.h"
#include "flight_identity.h"
#include "flight_pairs.h"
#include "flight_processes.h"
#include "input_files.h"
#include "json_file.h"
#include "new_strips.h"
#include "option_checks.h"
#include "read_text.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

constexpr const char* kReduced = "reduced.json";
constexpr std::size_t kFewestFlights = 2;

/// One flight of the command line.
struct Member {
  std::string argument;
  std::optional<FlightConfig> config;  ///< absent for a result folder
  std::vector<std::string> changes;    ///< --set values
  std::string name;                    ///< also that of its folder in --out
  fs::path folder;                     ///< of its result
  ReducedFlight flight;                ///< with its hashes only, before it is calibrated
  bool ready = false;                  ///< `flight` is complete
  bool found = false;                  ///< it was there before this run
  std::string failure;                 ///< why there is no result
};

bool IsThere(const fs::path& file) {
  std::error_code none;
  return fs::exists(file, none);
}

bool IsResultFolder(const std::string& argument) {
  return IsThere(fs::path(argument) / kReduced) && !IsThere(fs::path(argument) / "flight.yaml");
}

ReducedFlight ReadReduced(const fs::path& folder) {
  const fs::path file = folder / kReduced;
  const Json json = ReadJsonFile(file);
  return ReadReducedFlight(JsonPlace(json, file.string()));
}

/// Throws InvalidConfig if a section is missing that the dynamic network needs.
void ExpectSections(const FlightConfig& config) {
  const auto expect = [&](bool there, const char* section) {
    if (there) return;
    throw InvalidConfig(fmt::format("flight {} has no section '{}', which a calibration of several "
                                    "flights needs",
                                    config.name, section),
                        {config.file.string()});
  };
  expect(config.imu.has_value(), "imu");
  expect(config.gnss.has_value(), "gnss");
  expect(config.lidar.has_value(), "lidar");
  ExpectOneScanner(config, "a calibration of several flights");
}

class FleetRun {
 public:
  FleetRun(const std::vector<std::string>& flights, const std::vector<std::string>& changes,
           const FleetOptions& options, Run* run)
      : options_(options), changes_(changes), across_(options.across), run_(*run) {
    for (const std::string& flight : flights) members_.emplace_back().argument = flight;
  }

  void Calibrate() {
    ReadMembers();
    FindAcross();
    ExpectOneMounting();
    if (options_.georef) ExpectStrips();
    if (!options_.between.empty()) TieMembers();
    run_.progress().Stage("reading the data's hashes");
    for (Member& member : members_) FindEarlier(&member);
    ExpectDifferent();
    const Stopwatch watch;
    CalibrateMissing();
    const double calibrate_s = watch.seconds();
    run_.progress().Stage("combining the flights");
    const std::vector<ReducedFlight> flights = Choose();
    const FleetResult fleet = AdjustFleet(flights, shared_);
    Write(fleet, calibrate_s, watch.seconds());
    FailUnlessReliable(fleet);
    if (options_.georef) GeoreferenceFlights(Clouds(fleet), changes_, options_.at_once, &run_);
  }

 private:
  void ReadMembers() {
    std::vector<std::string> names;
    for (Member& member : members_) {
      if (IsResultFolder(member.argument)) {
        member.folder = member.argument;
        member.flight = ReadReduced(member.folder);
        member.name = member.flight.name;
        member.ready = member.found = true;
      } else {
        member.changes = changes_;
        member.config = ReadFlightConfig(member.argument, changes_);
        ExpectSections(*member.config);
        member.name = member.config->name;
      }
      MakeUnique(&member.name, &names);
      if (member.config) member.folder = run_.options().out / FolderName(member.name);
    }
  }

  static void MakeUnique(std::string* name, std::vector<std::string>* names) {
    const std::string first = *name;
    const auto taken = [&] {
      return std::any_of(names->begin(), names->end(), [&](const std::string& other) {
        return FolderName(other) == FolderName(*name);
      });
    };
    for (int k = 2; taken(); ++k) *name = fmt::format("{}_{}", first, k);
    names->push_back(*name);
  }

  void FindAcross() {
    if (!across_.empty()) {
      shared_ = ParseAcross(ParseYaml("across: " + across_ + "\n", "--across")["across"]);
      return;
    }
    const Member* first = nullptr;
    for (const Member& member : members_) {
      if (!member.config) continue;
      const AcrossConfig across = ReadAcross(member.config->file);
      if (first == nullptr) {
        first = &member;
        shared_ = across;
      }
      if (across == shared_) continue;
      throw InvalidConfig("the flights " + first->name + " and " + member.name +
                          " differ in their section `across`; give one for all with --across");
    }
  }

  void ExpectOneMounting() const {
    const auto mounting = [](const Member& member) {
      return member.config ? StatedMounting(*member.config) : member.flight.mounting;
    };
    for (const Member& member : members_) {
      const std::string key = FindDifference(mounting(members_.front()), mounting(member));
      if (key.empty()) continue;
      throw InvalidConfig(fmt::format(
          "the flights {} and {} differ in {}: flights of one calibration need the same scanner on "
          "the same mount",
          members_.front().name, member.name, key));
    }
  }

  /// Gives each flight its pairs with the others.
  void TieMembers() {
    std::vector<std::string> names;
    for (const Member& member : members_) {
      names.push_back(member.config ? member.config->name : member.flight.name);
    }
    const std::vector<std::string> ties = FindFlightPairs(options_.between, names);
    for (std::size_t k = 0; k < members_.size(); ++k) {
      Member& member = members_[k];
      if (!member.config || ties[k].empty()) continue;
      member.changes.push_back(ties[k]);
      member.config = ReadFlightConfig(member.argument, member.changes);
    }
  }

  void ExpectStrips() const {
    for (const Member& member : members_) {
      if (!member.config) {
        throw InvalidConfig(member.argument +
                            " is the result of a flight, without its point clouds: give the "
                            "flight instead (an earlier result in --out is used), or leave out "
                            "--georef");
      }
      ExpectBeamsInStrips(GeoreferenceableScanners(*member.config).front());
    }
  }

  /// Returns the flights of the result, each with the boresight of its points: that of all flights,
  /// or with a random walk its own.
  std::vector<FleetClouds> Clouds(const FleetResult& fleet) const {
    std::vector<FleetClouds> clouds;
    for (const FleetFlight& flight : fleet.flights) {
      const auto member = std::ranges::find(members_, flight.name, &Member::name);
      clouds.push_back({flight.name, member->argument, member->folder,
                        fleet.constant ? fleet.boresight.angles_rad : flight.alone.rad});
    }
    return clouds;
  }

  /// Takes the earlier result of a flight if it is of the same data and configuration.
  void FindEarlier(Member* member) const {
    if (!member->config) return;
    SetIdentity(*member->config, member->changes, &member->flight);
    if (!IsThere(member->folder / kReduced)) return;
    member->found = TakeResult(member);
    if (!member->found) member->failure.clear();
  }

  /// Reads the result of a flight. Sets the failure and returns false if it is of another flight.
  static bool TakeResult(Member* member) {
    try {
      ReducedFlight flight = ReadReduced(member->folder);
      if (flight.made_from != member->flight.made_from) {
        member->failure = "its data changed during the calibration";
        return false;
      }
      member->flight = std::move(flight);
      member->flight.name = member->name;
      return member->ready = true;
    } catch (const InvalidInput& error) {
      member->failure = FormatWithLocation(error);
      return false;
    }
  }

  void ExpectDifferent() const {
    for (std::size_t k = 0; k < members_.size(); ++k) {
      for (std::size_t i = 0; i < k; ++i) {
        if (members_[i].flight.data != members_[k].flight.data) continue;
        throw InvalidConfig(fmt::format("{} and {} have the same data: give each flight once",
                                        members_[i].argument, members_[k].argument));
      }
    }
  }

  void CalibrateMissing() {
    std::vector<Member*> missing;
    for (Member& member : members_) {
      if (!member.ready) missing.push_back(&member);
    }
    if (missing.empty()) return;
    ForFlights(missing.size(), options_.at_once, "flights", &run_,
               [&](std::size_t k, int threads) { CalibrateOne(threads, missing[k]); });
  }

  void CalibrateOne(int threads, Member* member) const {
    const int exit_code =
        RunIntoFolder({"calibrate", member->argument}, member->changes, threads, member->folder);
    if (IsThere(member->folder / kReduced) && TakeResult(member)) {
      std::error_code none;
      fs::remove(LogFile(member->folder), none);
      return;
    }
    if (!member->failure.empty()) return;
    member->failure = FailureText(exit_code, member->folder, "its calibration");
  }

  /// Returns the flights of the calibration, and notes the others.
  std::vector<ReducedFlight> Choose() {
    std::vector<ReducedFlight> flights;
    for (const Member& member : members_) {
      if (!member.ready) {
        excluded_.emplace_back(member.name, member.failure);
      } else if (member.flight.verdict != Verdict::kCalibrated && !options_.include_uncalibrated) {
        const std::vector<std::string>& reasons = member.flight.reasons;
        excluded_.emplace_back(member.name, std::string(Word(member.flight.verdict)) +
                                                (reasons.empty() ? "" : ": " + reasons.front()));
      } else {
        flights.push_back(member.flight);
      }
    }
    for (const auto& [name, reason] : excluded_) {
      run_.progress().Warn(fmt::format("flight {} is left out: {}", name, reason));
    }
    if (flights.size() < kFewestFlights) {
      throw InvalidInput(fmt::format(
          "{} of {} flights can be combined, but two are needed at least; flight {}: {}",
          flights.size(), members_.size(), excluded_.front().first, excluded_.front().second));
    }
    return flights;
  }

  void Write(const FleetResult& fleet, double calibrate_s, double total_s) {
    Json result = FleetJson(fleet, excluded_);
    result["timing_s"] = {
        {"read", nullptr}, {"solve", calibrate_s}, {"covariance", nullptr}, {"total", total_s}};
    run_.AddFile("result.json", FormatJson(result));
    run_.AddFile("config.resolved.yaml", ConfigText());
    Json& report = run_.report();
    report["flight"] = result["flight"];
    report["counts"] = {
        {"flights", members_.size()},
        {"flights of earlier runs",
         std::count_if(members_.begin(), members_.end(), [](const Member& m) { return m.found; })},
        {"flights left out", excluded_.size()}};
    Json hashes = Json::object();
    for (const Member& member : members_) hashes[member.name] = member.flight.made_from;
    report["reduced_flights"] = hashes;
    Inputs reduced;
    for (const Member& member : members_) {
      reduced.folders.push_back(member.folder.parent_path());
      reduced.files.push_back(member.folder / kReduced);
    }
    report["inputs"] = InputFilesJson(reduced);
    report["timings_s"] = {{"flights", calibrate_s}};
    fmt::print("{}", FleetSummary(fleet, excluded_));
  }

  std::string ConfigText() const {
    std::string text = "flights:\n";
    for (const Member& member : members_) {
      text += "  - {name: " + Json(member.name).dump() + ", from: " + Json(member.argument).dump() +
              "}\n";
    }
    return text + "across: " + FormatAcross(shared_) + "\n";
  }

  static void FailUnlessReliable(const FleetResult& fleet) {
    const Verdict verdict = fleet.boresight.verdict;
    if (verdict != Verdict::kContradicted && verdict != Verdict::kNotObservable) return;
    throw FailedWithResults(Word(verdict), FleetReasons(fleet).front() + "; see result.json");
  }

  const FleetOptions& options_;
  const std::vector<std::string>& changes_;
  const std::string& across_;  // text of --across
  Run& run_;
  std::vector<Member> members_;
  AcrossConfig shared_;
  std::vector<ExcludedFlight> excluded_;
};

}  // namespace

void AddFleetOptions(CLI::App* app, FleetOptions* options) {
  app->add_option("--across", options->across,
                  "Several flights: what they share, as the section of flight.yaml, e.g. "
                  "'[{unknown: boresight, random_walk_deg: 0.002}, lidar_range_offset]'");
  app->add_option("--at-once", options->at_once,
                  "Several flights: number of flights calibrated at the same time; each takes the "
                  "memory of one")
      ->check(WholeNumber(1, 1024))
      ->capture_default_str();
  app->add_option("--between", options->between,
                  "Several flights: folder of `dn match A B ...` with the pairs between them");
  app->add_flag("--include-uncalibrated", options->include_uncalibrated,
                "Several flights: also combines flights whose verdict is not `calibrated`");
}

Inputs FleetInputs(const std::vector<std::string>& flights, const std::vector<std::string>& changes,
                   const std::string& between) {
  Inputs all;
  if (!between.empty()) all.folders.emplace_back(between);
  const auto append = [](std::vector<fs::path>* to, const std::vector<fs::path>& from) {
    to->insert(to->end(), from.begin(), from.end());
  };
  for (const std::string& flight : flights) {
    if (IsResultFolder(flight)) {
      all.folders.emplace_back(flight);
      all.files.push_back(fs::path(flight) / kReduced);
      continue;
    }
    const Inputs one = FlightInputs(flight, changes);
    append(&all.folders, one.folders);
    append(&all.files, one.files);
    append(&all.strips, one.strips);
    append(&all.circular_links, one.circular_links);
  }
  return all;
}

void CalibrateFlights(const std::vector<std::string>& flights,
                      const std::vector<std::string>& changes, const FleetOptions& options,
                      Run& run) {
  FleetRun(flights, changes, options, &run).Calibrate();
}

}  // namespace dn::apps
