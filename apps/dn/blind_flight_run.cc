#include "blind_flight_run.h"

#include <dn/adjustment/adjust.h>
#include <dn/diagnosis/signature.h>
#include <dn/effects/effect_table.h>
#include <dn/error.h>
#include <dn/files/atomic_file.h>
#include <dn/interrupted.h>
#include <dn/sim/simulate.h>
#include <fmt/format.h>

#include "child_process.h"
#include "interruption.h"
#include "json_file.h"
#include "output_folder.h"
#include "read_text.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

constexpr double kLongestRun_s = 3600.0;

std::string LastLine(const fs::path& file) {
  std::string text = ReadText(file);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

/// The folders and files of one flight.
struct Places {
  Places(const fs::path& out, int number)
      : name(fmt::format("{:03}", number)),
        flight(out / "flights" / name),
        truth(out / "truth" / (name + ".yaml")),
        runs(out / "runs" / name),
        adapted_config(runs / "gap" / "flight.adapted.yaml") {}

  std::string name;
  fs::path flight, truth, runs, adapted_config;
};

SimulateOptions MakeSimulateOptions(const BlindFlight& flight) {
  SimulateOptions simulate;
  simulate.seed = flight.seed;
  simulate.progress = [](const std::string&, double) {
    if (SignalReceived()) throw dn::Interrupted();
  };
  if (flight.outsider) simulate.own = MakeOwnErrors(*flight.outsider, flight.scenario);
  return simulate;
}

void WriteFlight(const BlindFlight& flight, const Places& places) {
  const SimulatedFlight simulated = Simulate(flight.scenario, MakeSimulateOptions(flight));
  std::string truth = FormatTruth(simulated) + "base: " + flight.base + "\n";
  if (flight.outsider) {
    truth += fmt::format("outsider: {{name: {}, parameters: {}}}\n", flight.outsider->name,
                         flight.outsider->parameters.dump());
  }
  fs::create_directories(places.truth.parent_path());
  fs::create_directories(places.flight.parent_path());
  WriteFileAtomically(places.truth, truth);
  OutputDirectory folder(places.flight);
  WriteMeasurements(simulated, folder);
  folder.Commit();
}

/// Computes the signature of the single effect in a flight. Returns nullopt for no or several
/// effects, for an effect of another kind than kFixed, and if the computation fails.
std::optional<BlindSignature> ContentSignature(const BlindFlight& flight) {
  if (!flight.outsider && flight.scenario.effects.size() != 1) return std::nullopt;
  dn::GapOptions options;
  options.interrupted = [] { return SignalReceived(); };
  for (const Effect& effect : flight.scenario.effects) {
    if (FindEffect(effect.name)->kind != EffectKind::kFixed) return std::nullopt;
    if (flight.left_out) options.left_out.push_back(effect.name);
  }
  SimulateOptions simulate = MakeSimulateOptions(flight);
  simulate.noise = false;
  const Flight with = Simulate(flight.scenario, simulate).flight;
  Scenario nothing = flight.scenario;
  nothing.effects.clear();
  simulate.own = {};
  try {
    const Signature signature = ComputeSignature(with, Simulate(nothing, simulate).flight, options);
    return BlindSignature{signature.lambda, signature.lambda_left, signature.nearest};
  } catch (const InvalidInput&) {
    return std::nullopt;
  } catch (const NotConverged&) {
    return std::nullopt;
  } catch (const RankDeficient&) {
    return std::nullopt;
  }
}

/// Removes the staged files that a killed program left in its results folder.
void RemoveStaged(const fs::path& out) {
  try {
    const OutputDirectory swept(out);
  } catch (const std::exception&) {
    return;  // the program had not made its results folder yet
  }
}

/// Runs a command of this program in a process of its own. `read` converts its result file to the
/// outcome.
template <class T, class Read>
Outcome<T> RunCommand(const std::vector<std::string>& arguments, const fs::path& out,
                      const std::string& result_name, const Read& read) {
  std::vector<std::string> command{kThisProgram};
  command.insert(command.end(), arguments.begin(), arguments.end());
  command.insert(command.end(), {"--threads", "1", "--out", out.string()});
  fs::path log = out;
  log += ".log";
  const ProcessUsage usage =
      RunProgram(command, log, {kLongestRun_s, [] { return SignalReceived(); }});
  if (usage.exit_code > kFirstSignal) RemoveStaged(out);
  Outcome<T> outcome;
  outcome.time_s = usage.wall_s;
  const fs::path result = out / result_name;
  if (!fs::exists(result)) {
    outcome.failure = fmt::format("exit code {}: {}", usage.exit_code, LastLine(log));
    return outcome;
  }
  try {
    const Json json = ReadJsonFile(result);
    outcome.result = read(JsonPlace(json, result.string()));
  } catch (const std::exception& error) {
    outcome.failure = error.what();
  }
  return outcome;
}

Outcome<BlindCalibration> Calibrate(const fs::path& flight, const fs::path& out,
                                    const Eigen::Vector3d& boresight_deg) {
  return RunCommand<BlindCalibration>(
      {"calibrate", flight.string()}, out, "result.json",
      [&](const JsonPlace& json) { return CalibrationFromResultJson(json, boresight_deg); });
}

void RunCommands(const Places& places, const std::vector<std::string>& gap_options,
                 BlindRecord* record) {
  fs::remove_all(places.runs);
  fs::create_directories(places.runs);
  std::vector<std::string> gap{"gap", places.flight.string()};
  gap.insert(gap.end(), gap_options.begin(), gap_options.end());
  if (record->content == BlindContent::kLeftOut) {
    gap.insert(gap.end(), {"--without", record->effects.front().name});
  }
  record->diagnosis = RunCommand<BlindDiagnosis>(
      gap, places.runs / "gap", "gap.json",
      [&](const JsonPlace& json) { return DiagnosisFromGapJson(json, record->boresight_deg); });
  record->calibrated = Calibrate(places.flight, places.runs / "calibrate", record->boresight_deg);
  if (!fs::exists(places.adapted_config)) return;
  record->adapted =
      Calibrate(places.adapted_config, places.runs / "adapted", record->boresight_deg);
}

}  // namespace

BlindRecord RunBlindFlight(const BlindFlight& flight, const BlindRunOptions& options) {
  const Places places(options.out, flight.number);
  ExpectRealFolder(places.flight);
  BlindRecord record = MakeTruthRecord(flight);
  try {
    WriteFlight(flight, places);
    record.signature = ContentSignature(flight);
  } catch (const InvalidInput& error) {
    record.diagnosis.failure = std::string("the flight cannot be simulated: ") + error.what();
    return record;
  }
  RunCommands(places, options.gap_options, &record);
  if (options.discard_flights) fs::remove_all(places.flight);
  return record;
}

}  // namespace dn::apps
