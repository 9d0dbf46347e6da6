#include <dn/builder/flight_network.h>
#include <dn/builder/flight_nodes.h>
#include <dn/builder/gnss_factors.h>
#include <dn/error.h>
#include <dn/files/flight.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_files.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <optional>

#include "calibrate_strips.h"
#include "command.h"
#include "data_hints.h"
#include "scanner_beams.h"
#include "shaking_json.h"
#include "strip_hints.h"
#include "strip_lines.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

// Largest share of repeated rows that can occur by chance, e.g. with a coarse sensor at rest.
constexpr double kRepeatedShare = 0.05;
constexpr FlightNeeds kEverything{.imu = true,
                                  .gnss = true,
                                  .pairs = true,
                                  .trajectory = true,
                                  .control = true,
                                  .optional = true};

struct CheckArguments {
  CommonOptions common;
  std::string flight;
};

/// The data that could be read from a folder, and the problems of the files that could not.
struct Contents {
  Flight flight;
  std::vector<std::string> problems;
  std::exception_ptr first_problem;
};

/// Reads the parts of a flight one after the other and keeps those that can be read.
class PartReader {
 public:
  explicit PartReader(const FlightConfig& config) : config_(config) {}

  /// Adds a part if it can be read alone and together with the parts before it.
  void Try(bool FlightNeeds::*part) {
    FlightNeeds alone{.optional = true};
    alone.*part = true;
    FlightNeeds together = needs_;
    together.*part = true;
    if (Reads(alone) && Reads(together)) needs_ = together;
  }

  Contents Take() {
    contents_.flight = ReadFlight(config_, needs_);
    return std::move(contents_);
  }

 private:
  bool Reads(const FlightNeeds& needs) {
    try {
      ReadFlight(config_, needs);
      return true;
    } catch (const InvalidInput& error) {
      AddProblem(error);
      return false;
    }
  }

  void AddProblem(const InvalidInput& error) {
    const std::string text = FormatWithLocation(error);
    if (std::find(contents_.problems.begin(), contents_.problems.end(), text) !=
        contents_.problems.end()) {
      return;
    }
    contents_.problems.push_back(text);
    if (!contents_.first_problem) contents_.first_problem = std::current_exception();
  }

  const FlightConfig& config_;
  FlightNeeds needs_{.optional = true};
  Contents contents_;
};

Contents ReadContents(const FlightConfig& config) {
  try {
    return {ReadFlight(config, kEverything), {}, nullptr};
  } catch (const InvalidInput&) {
    PartReader reader(config);
    for (const auto part : {&FlightNeeds::imu, &FlightNeeds::gnss, &FlightNeeds::trajectory,
                            &FlightNeeds::pairs, &FlightNeeds::control}) {
      reader.Try(part);
    }
    return reader.Take();
  }
}

std::string Count(std::size_t n, const std::string& noun) {
  return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s");
}

std::string GapsText(const ImuData& imu) {
  std::string text = imu.gaps.empty() ? "no gap" : Count(imu.gaps.size(), "gap");
  if (!imu.bridges.empty()) text += ", " + Count(imu.bridges.size(), "short gap") + " interpolated";
  return text;
}

void SummariseImu(const Flight& flight, Json* json) {
  const ImuData& imu = *flight.imu;
  fmt::print("inertial data   {} epochs, {:.3f} .. {:.3f} s, {:.2f} Hz, {} {:.1f} ms, {}\n",
             imu.samples.size(), imu.t_begin_s(), imu.t_end_s(), 1.0 / imu.nominal_dt_s,
             imu.uneven ? "uneven, jitter up to" : "jitter up to", 1e3 * imu.max_jitter_s,
             GapsText(imu));
  const double repeated =
      static_cast<double>(imu.repeated_values) / static_cast<double>(imu.samples.size());
  if (repeated > kRepeatedShare) {
    fmt::print(
        "                {} rows ({:.0f} %) repeat the values of the row before: the sensor is "
        "slower than its log, about {:.1f} Hz\n",
        imu.repeated_values, 100.0 * repeated, (1.0 - repeated) / imu.nominal_dt_s);
  }
  (*json)["imu"] = {
      {"epochs", imu.samples.size()}, {"t_begin_s", imu.t_begin_s()},
      {"t_end_s", imu.t_end_s()},     {"rate_hz", 1.0 / imu.nominal_dt_s},
      {"uneven", imu.uneven},         {"max_jitter_s", imu.max_jitter_s},
      {"gaps", imu.gaps.size()},      {"rows_that_repeat_values", imu.repeated_values}};
  const std::optional<Shaking> shaking = FindShaking(imu);
  PrintShaking(shaking, "                ");
  (*json)["imu"]["shaking"] = ShakingJson(shaking);
}

/// Prints the attitude of the sensor axes relative to gravity and course, as found in the data.
void SummariseAxes(const BodyDirections& directions, Json* json) {
  const Eigen::Vector3d& down = directions.down_b;
  const double roll_deg = std::atan2(down.y(), down.z()) * kDegPerRad;
  const double pitch_deg = -std::asin(std::clamp(down.x(), -1.0, 1.0)) * kDegPerRad;
  std::string text =
      fmt::format("mean roll {:.1f}, pitch {:.1f} deg from gravity", roll_deg, pitch_deg);
  Json& axes = (*json)["imu"]["axes"] = {{"roll_deg", roll_deg}, {"pitch_deg", pitch_deg}};
  if (directions.course_b) {
    const Eigen::Vector3d& course = *directions.course_b;
    const double heading_deg = std::atan2(-course.y(), course.x()) * kDegPerRad;
    text += fmt::format("; heading about {:.0f} deg from the course", heading_deg);
    axes["heading_from_course_deg"] = heading_deg;
  } else {
    text += "; heading relative to the course unknown";
  }
  fmt::print("                {}\n", text);
}

void SummariseGnss(const Flight& flight, Json* json) {
  const std::vector<MapGnssEpoch>& epochs = flight.gnss->epochs;
  double longest_s = 0.0;
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < epochs.size(); ++i) {
    steps_s.push_back(epochs[i].t_s - epochs[i - 1].t_s);
    longest_s = std::max(longest_s, steps_s.back());
  }
  const bool velocity = UsesVelocities(flight);
  const double span_s = epochs.back().t_s - epochs.front().t_s;
  const double rate_hz = span_s > 0.0 ? static_cast<double>(steps_s.size()) / span_s : 0.0;
  fmt::print(
      "GNSS data       {} epochs, {:.3f} .. {:.3f} s, {:.2f} Hz, longest gap {:.1f} s, velocity "
      "{}\n",
      epochs.size(), epochs.front().t_s, epochs.back().t_s, rate_hz, longest_s,
      velocity ? "used" : "not used");
  (*json)["gnss"] = {{"epochs", epochs.size()},
                     {"t_begin_s", epochs.front().t_s},
                     {"t_end_s", epochs.back().t_s},
                     {"longest_hole_s", longest_s},
                     {"velocity", velocity}};
}

void PrintLine(const StripLine& line) {
  fmt::print("                strip {}: {:.1f} .. {:.1f} s", line.strip.name, line.strip.t0_s,
             line.strip.t1_s);
  if (line.known) {
    fmt::print(", {:.0f} m, course {:.0f} deg, height {:.0f} m", line.length_m,
               line.course_rad * kDegPerRad, line.height_m);
  }
  fmt::print("\n");
}

Json LineJson(const StripLine& line) {
  Json json{{"name", line.strip.name}, {"t0_s", line.strip.t0_s}, {"t1_s", line.strip.t1_s}};
  if (line.known) {
    json["length_m"] = line.length_m;
    json["course_deg"] = line.course_rad * kDegPerRad;
    json["height_m"] = line.height_m;
  }
  return json;
}

void SummarisePairs(const Flight& flight, Json* json) {
  const std::vector<StripInterval> strips = FindStrips(flight);
  const std::vector<StripLine> lines = StripLines(flight, strips);
  fmt::print("pairs           {} in {} files, {} strips\n", flight.pairs->pairs.size(),
             flight.pairs->files.size(), strips.size());
  Json list = Json::array(), between = Json::object();
  for (const StripLine& line : lines) {
    PrintLine(line);
    list.push_back(LineJson(line));
  }
  for (const auto& [name, pairs] : CountStripPairs(flight, strips)) {
    fmt::print("                strips {}: {} pairs, in {} of 20 sections (10 per strip)\n", name,
               pairs.count, pairs.tenths);
    between[name] = {{"count", pairs.count}, {"tenths", pairs.tenths}};
  }
  const std::string geometry = DescribeGeometry(lines, MeanRange(flight.pairs->pairs));
  if (!geometry.empty()) fmt::print("                {}\n", geometry);
  const std::vector<ScannerBeams> beams = CountScannerBeams(flight);
  for (const ScannerBeams& one : beams) fmt::print("                {}\n", Words(one));
  (*json)["pairs"] = {{"count", flight.pairs->pairs.size()},
                      {"files", flight.pairs->files.size()},
                      {"strips", list},
                      {"between", between},
                      {"geometry", geometry}};
  if (!beams.empty()) (*json)["pairs"]["beams"] = ToJson(beams);
}

struct CommandVerdict {
  std::string command;
  bool possible = false;
  std::string why;  ///< the work of the command, or the missing data
};

void SummariseControl(const ControlData& control, Json* json) {
  const auto count = [&](const auto& counts) {
    return std::count_if(control.points.begin(), control.points.end(), counts);
  };
  const auto checks = count([](const ControlPoint& point) { return point.is_check; });
  const auto planes = count([](const ControlPoint& point) { return point.plane.has_value(); });
  const auto vectors = count([](const ControlPoint& point) { return !point.returns.empty(); });
  fmt::print(
      "control         {} observations and {} checks, {} of them planes, {} with a laser "
      "vector\n",
      static_cast<long>(control.points.size()) - checks, checks, planes, vectors);
  (*json)["control"] = {{"points", control.points.size()},
                        {"checks", checks},
                        {"planes", planes},
                        {"with_vector", vectors}};
}

std::string Missing(const std::vector<std::pair<std::string, bool>>& needs) {
  std::string missing;
  for (const auto& [what, there] : needs) {
    if (!there) missing += (missing.empty() ? "missing: " : ", ") + what;
  }
  return missing;
}

std::string WhatSmoothDoes(const Flight& flight) {
  return fmt::format("{} inertial and {} GNSS epochs into a trajectory with its sigmas",
                     flight.imu->samples.size(), flight.gnss->epochs.size());
}

bool HasPairs(const Flight& flight) { return flight.pairs && !flight.pairs->pairs.empty(); }

/// Returns the pairs that a calibration uses. Without any, it matches the strips.
std::string PairWords(const Flight& flight) {
  return HasPairs(flight) ? fmt::format("{} pairs", flight.pairs->pairs.size())
                          : "the pairs of the strips, which it matches first";
}

std::string WhatCalibrateDoes(const Flight& flight) {
  std::vector<std::string> unknowns;
  for (const EstimateEntry& entry : flight.config.estimate) unknowns.push_back(entry.unknown);
  std::string text = fmt::format("{} from {}", fmt::join(unknowns, ", "), PairWords(flight));
  if (!HasPairs(flight)) return text;
  return text + fmt::format(", nodes at {:g} Hz in the strips", NodeRateHz(flight, true));
}

std::string WhatGaussHelmertDoes(const Flight& flight) {
  const std::string on =
      flight.trajectory ? flight.config.trajectory->file : "a trajectory that it smooths first";
  return "boresight from " + PairWords(flight) + " on " + on;
}

std::vector<CommandVerdict> Verdicts(const Flight& flight, bool strips) {
  const bool imu = flight.imu.has_value();
  const bool gnss = flight.gnss.has_value();
  const bool matches = HasStripsAlone(flight.config);
  const bool pairs = HasPairs(flight) || matches;
  const bool one_scanner = NumScanners(flight.config) < 2;
  const std::string one = "the choice of a scanner (--scanner)";
  std::vector<CommandVerdict> verdicts;
  const auto add = [&](const std::string& command,
                       const std::vector<std::pair<std::string, bool>>& needs, const auto& does) {
    const std::string missing = Missing(needs);
    verdicts.push_back({command, missing.empty(), missing.empty() ? does() : missing});
  };
  add("smooth", {{"inertial data", imu}, {"GNSS data", gnss}},
      [&] { return WhatSmoothDoes(flight); });
  add("calibrate --method dn", {{"inertial data", imu}, {"GNSS data", gnss}, {"pairs", pairs}},
      [&] { return WhatCalibrateDoes(flight); });
  add("calibrate --method gh",
      {{one, one_scanner},
       {"a trajectory", flight.trajectory.has_value() || (imu && gnss)},
       {"pairs", pairs},
       {"pairs inside the trajectory", !flight.counts.contains("pairs outside the trajectory")}},
      [&] { return WhatGaussHelmertDoes(flight); });
  add("match",
      {{"the section 'lidar'", flight.config.lidar.has_value()},
       {"strips", strips},
       {"their system (strips_crs)", flight.config.strips_crs != "none"},
       {"a trajectory, or inertial and GNSS data", flight.trajectory.has_value() || (imu && gnss)}},
      [] { return std::string("point pairs from the overlaps of the strips"); });
  add("georef",
      {{one, one_scanner},
       {"a trajectory", flight.trajectory.has_value()},
       {"the section 'lidar'", flight.config.lidar.has_value()},
       {"strips", strips},
       {"their system (strips_crs)", flight.config.strips_crs != "none"}},
      [] { return std::string("the points of the strips by trajectory and boresight"); });
  return verdicts;
}

/// Returns one sentence on all files: which calibrations or trajectories they allow.
std::string Summary(const std::vector<CommandVerdict>& verdicts, std::size_t hints,
                    std::size_t problems) {
  if (problems > 0) return "not usable: a file cannot be read; mend the problem below first";
  std::vector<std::string> possible;
  for (const CommandVerdict& verdict : verdicts) {
    const bool estimates = verdict.command != "match" && verdict.command != "georef";
    if (verdict.possible && estimates) possible.push_back("dn " + verdict.command);
  }
  if (possible.empty()) return "incomplete: no calibration and no trajectory is possible yet";
  const std::string list = fmt::format("{}", fmt::join(possible, ", "));
  if (hints == 0) return "ready: " + list;
  return fmt::format("doubtful: look at the {} above before {}",
                     hints == 1 ? "hint" : fmt::format("{} hints", hints), list);
}

void PrintVerdicts(const std::vector<CommandVerdict>& verdicts, Json* json) {
  (*json)["commands"] = Json::object();
  for (const CommandVerdict& verdict : verdicts) {
    fmt::print("dn {:<22} {}{}\n", verdict.command, verdict.possible ? "possible: " : "",
               verdict.why);
    (*json)["commands"][verdict.command] = {{"possible", verdict.possible},
                                            {"why", verdict.possible ? "" : verdict.why},
                                            {"does", verdict.possible ? verdict.why : ""}};
  }
}

void PrintHints(const std::vector<DataHint>& hints, Json* json) {
  (*json)["hints"] = Json::array();
  for (const DataHint& hint : hints) {
    fmt::print("look at         {}\n", HintText(hint));
    (*json)["hints"].push_back({{"text", hint.text}, {"key", hint.key}, {"value", hint.value}});
  }
}

/// Returns a hint for each strip that does not belong to the path of the flight.
std::vector<DataHint> StripHints(const std::vector<fs::path>& files, const Flight& flight) {
  std::vector<DataHint> hints;
  const std::optional<RoughPath> path = KnownPath(flight);
  if (!path || !flight.config.lidar) return hints;
  const bool with_vectors = NumScanners(flight.config) < 2;
  for (const fs::path& file : files) {
    const auto found = CompareStrip(file, flight.config, *path, with_vectors);
    if (!found) continue;
    hints.push_back({file.filename().string() + ": " +
                         StripDisagreementText(*found, flight.config.lidar->time_offset_s),
                     "", ""});
  }
  return hints;
}

void SummariseStrips(const std::vector<std::filesystem::path>& files, const FlightConfig& config,
                     Json* json) {
  const std::string& crs = config.strips_crs;
  fmt::print("strips          {} in {}\n", files.size(), ShownCrsName(crs));
  Json list = Json::array();
  for (const std::filesystem::path& file : files) {
    const auto reader = OpenStrip(file);
    const std::string note = CheckStripCrs(reader->crs(), crs, file);
    const std::string name = NumScanners(config) < 2
                                 ? file.filename().string()
                                 : (file.parent_path().filename() / file.filename()).string();
    const std::string count =
        reader->points() ? fmt::format("{} points", *reader->points()) : std::string("text");
    fmt::print("                {}: {}, {}laser vectors{}{}\n", name, count,
               reader->has_vectors() ? "" : "no ", reader->has_time() ? "" : ", no GPS time",
               note.empty() ? "" : "; " + note);
    if (config.lidar) {
      const VectorOrigin origin = FindVectorOrigin(*reader, StripsGeoreferencing(config), file);
      const std::string warning = VectorWarning(origin, name);
      if (!warning.empty()) fmt::print("look at         {}\n", warning);
    }
    list.push_back({{"name", name},
                    {"points", reader->points() ? Json(*reader->points()) : Json()},
                    {"laser_vectors", reader->has_vectors()},
                    {"gps_time", reader->has_time()}});
  }
  (*json)["strips"] = {{"crs", crs}, {"files", list}};
}

void Summarise(const Flight& flight, Json* json) {
  const Geodetic& origin = flight.frame.origin();
  fmt::print("flight          {}\norigin          {:.8f} deg, {:.8f} deg, {:.3f} m\n",
             flight.config.name, origin.lat_rad * kDegPerRad, origin.lon_rad * kDegPerRad,
             origin.h_m);
  const DataAgreement agreement = FindDataAgreement(flight);
  if (flight.imu) SummariseImu(flight, json);
  if (agreement.directions) SummariseAxes(*agreement.directions, json);
  if (flight.gnss && !flight.gnss->epochs.empty()) SummariseGnss(flight, json);
  if (flight.pairs && !flight.pairs->pairs.empty()) SummarisePairs(flight, json);
  if (flight.control) SummariseControl(*flight.control, json);
  if (flight.trajectory) {
    fmt::print("trajectory      {} points, {:.3f} .. {:.3f} s\n",
               flight.trajectory->points().size(), flight.trajectory->t_begin_s(),
               flight.trajectory->t_end_s());
  }
  const std::vector<fs::path> strips = FindStripFiles(flight.config);
  if (!strips.empty()) SummariseStrips(strips, flight.config, json);
  std::vector<DataHint> hints = DataHints(flight, agreement);
  if (std::none_of(hints.begin(), hints.end(), DoubtsPoses)) {
    const std::vector<DataHint> more = StripHints(strips, flight);
    hints.insert(hints.end(), more.begin(), more.end());
  }
  PrintHints(hints, json);
  for (const auto& [reason, count] : flight.counts) {
    if (count > 0) fmt::print("note            {}: {}\n", reason, count);
  }
  const std::vector<CommandVerdict> verdicts = Verdicts(flight, !strips.empty());
  PrintVerdicts(verdicts, json);
  const std::string summary =
      Summary(verdicts, (*json)["hints"].size(), (*json)["problems"].size());
  fmt::print("verdict         {}\n", summary);
  (*json)["verdict"] = summary;
}

void Check(const CheckArguments& options, Run& run) {
  const FlightConfig config = ReadFlightConfig(options.flight, options.common.changes);
  const Contents contents = ReadContents(config);
  Json& report = run.report();
  report["flight"] = config.name;
  report["counts"] = contents.flight.counts;
  report["problems"] = contents.problems;
  Summarise(contents.flight, &report);
  for (const std::string& problem : contents.problems) {
    fmt::print("problem         {}\n", problem);
  }
  if (contents.first_problem) std::rethrow_exception(contents.first_problem);
  run.AddFile("config.resolved.yaml", FormatFlightConfig(contents.flight.config));
}

}  // namespace

void AddCheck(CLI::App* program, Action* action) {
  auto options = std::make_shared<CheckArguments>();
  CLI::App* app = program->add_subcommand(
      "check", "Validates and summarises a flight folder, and lists the commands it has data for");
  AddFlightOptions(app, &options->flight, &options->common);
  AddCommonOptions(app, &options->common, false);
  app->footer("Example: dn check flight");
  app->callback([options, action] {
    *action = [options] {
      options->common.inputs = FlightInputs(options->flight, options->common.changes);
      return Execute("check", options->common, [&](Run& run) { Check(*options, run); });
    };
  });
}

}  // namespace dn::apps
