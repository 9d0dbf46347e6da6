#include <dn/builder/flight_network.h>
#include <dn/flight/flight.h>
#include <dn/flight/strip_files.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "command.h"

namespace dn::apps {
namespace {

struct Options {
  CommonOptions common;
  std::string flight;
};

struct CommandVerdict {
  std::string command;
  bool possible = false;
  std::string why;
};

std::string Missing(const std::vector<std::pair<std::string, bool>>& needs) {
  std::string missing;
  for (const auto& [what, there] : needs) {
    if (!there) missing += (missing.empty() ? "missing: " : ", ") + what;
  }
  return missing;
}

std::vector<CommandVerdict> Verdicts(const Flight& flight, bool strips) {
  const bool imu = flight.imu.has_value();
  const bool gnss = flight.gnss.has_value();
  const bool pairs = flight.pairs && !flight.pairs->pairs.empty();
  std::vector<CommandVerdict> verdicts;
  const auto add = [&](const std::string& command,
                       const std::vector<std::pair<std::string, bool>>& needs) {
    const std::string missing = Missing(needs);
    verdicts.push_back({command, missing.empty(), missing});
  };
  add("smooth", {{"inertial data", imu}, {"GNSS data", gnss}});
  add("calibrate --method dn", {{"inertial data", imu}, {"GNSS data", gnss}, {"pairs", pairs}});
  add("calibrate --method gh",
      {{"a trajectory", flight.trajectory.has_value()},
       {"pairs", pairs},
       {"pairs inside the trajectory", !flight.counts.contains("pairs outside the trajectory")}});
  add("georef", {{"a trajectory", flight.trajectory.has_value()},
                 {"the section 'lidar'", flight.config.lidar.has_value()},
                 {"strips", strips},
                 {"their system (strips_crs)", flight.config.strips_crs != "none"}});
  return verdicts;
}

void SummariseImu(const Flight& flight, Json* json) {
  const ImuData& imu = *flight.imu;
  Eigen::Vector3d f = Eigen::Vector3d::Zero();
  for (const ImuSample& sample : imu.samples) f += sample.f_b_mps2;
  f /= static_cast<double>(imu.samples.size());
  fmt::print(
      "inertial data   {} epochs, {:.3f} .. {:.3f} s, {:.2f} Hz, jitter {:.1f} ms, {} gaps\n",
      imu.samples.size(), imu.t_begin_s(), imu.t_end_s(), 1.0 / imu.nominal_dt_s,
      1e3 * imu.max_jitter_s, imu.gaps.size());
  fmt::print("                mean specific force ({:.2f}, {:.2f}, {:.2f}) m/s^2\n", f.x(), f.y(),
             f.z());
  (*json)["imu"] = {{"epochs", imu.samples.size()},     {"t_begin_s", imu.t_begin_s()},
                    {"t_end_s", imu.t_end_s()},         {"rate_hz", 1.0 / imu.nominal_dt_s},
                    {"max_jitter_s", imu.max_jitter_s}, {"gaps", imu.gaps.size()}};
}

void SummariseGnss(const Flight& flight, Json* json) {
  const std::vector<MapGnssEpoch>& epochs = flight.gnss->epochs;
  double longest_s = 0.0;
  for (std::size_t i = 1; i < epochs.size(); ++i) {
    longest_s = std::max(longest_s, epochs[i].t_s - epochs[i - 1].t_s);
  }
  const bool velocity = std::any_of(epochs.begin(), epochs.end(), [&](const MapGnssEpoch& epoch) {
    return UsesVelocity(epoch, *flight.config.gnss);
  });
  fmt::print("GNSS data       {} epochs, {:.3f} .. {:.3f} s, longest hole {:.1f} s, velocity {}\n",
             epochs.size(), epochs.front().t_s, epochs.back().t_s, longest_s,
             velocity ? "used" : "not used");
  (*json)["gnss"] = {{"epochs", epochs.size()},
                     {"t_begin_s", epochs.front().t_s},
                     {"t_end_s", epochs.back().t_s},
                     {"longest_hole_s", longest_s},
                     {"velocity", velocity}};
}

void SummarisePairs(const Flight& flight, Json* json) {
  const std::vector<StripInterval> strips = FindStrips(flight);
  fmt::print("pairs           {} in {} files, {} strips\n", flight.pairs->pairs.size(),
             flight.pairs->files.size(), strips.size());
  Json list = Json::array();
  for (const StripInterval& strip : strips) {
    fmt::print("                strip {}: {:.1f} .. {:.1f} s\n", strip.name, strip.t0_s,
               strip.t1_s);
    list.push_back({{"name", strip.name}, {"t0_s", strip.t0_s}, {"t1_s", strip.t1_s}});
  }
  (*json)["pairs"] = {{"count", flight.pairs->pairs.size()},
                      {"files", flight.pairs->files.size()},
                      {"strips", list}};
}

void SummariseStrips(const std::vector<std::filesystem::path>& files, const std::string& crs,
                     Json* json) {
  fmt::print("strips          {} in {}\n", files.size(), crs);
  Json list = Json::array();
  for (const std::filesystem::path& file : files) {
    const auto reader = OpenStrip(file);
    const std::string note = CheckStripCrs(reader->crs(), crs, file);
    const std::string name = file.filename().string();
    const std::string count =
        reader->points() ? fmt::format("{} points", *reader->points()) : std::string("text");
    fmt::print("                {}: {}, {}laser vectors{}{}\n", name, count,
               reader->has_vectors() ? "" : "no ", reader->has_time() ? "" : ", no GPS time",
               note.empty() ? "" : "; " + note);
    list.push_back({{"name", name},
                    {"points", reader->points() ? Json(*reader->points()) : Json()},
                    {"laser_vectors", reader->has_vectors()},
                    {"gps_time", reader->has_time()}});
  }
  (*json)["strips"] = {{"crs", crs}, {"files", list}};
}

void Check(const Options& options, Run& run) {
  FlightNeeds needs;
  needs.imu = needs.gnss = needs.pairs = needs.trajectory = true;
  needs.optional = true;
  const Flight flight = ReadFlight(options.flight, needs);
  const Geodetic& origin = flight.frame.origin();
  fmt::print("flight          {}\norigin          {:.8f} deg, {:.8f} deg, {:.3f} m\n",
             flight.config.name, origin.lat_rad * kDegPerRad, origin.lon_rad * kDegPerRad,
             origin.h_m);
  Json& report = run.report;
  report["flight"] = flight.config.name;
  if (flight.imu) SummariseImu(flight, &report);
  if (flight.gnss && !flight.gnss->epochs.empty()) SummariseGnss(flight, &report);
  if (flight.pairs && !flight.pairs->pairs.empty()) SummarisePairs(flight, &report);
  if (flight.trajectory) {
    fmt::print("trajectory      {} points, {:.3f} .. {:.3f} s\n",
               flight.trajectory->points().size(), flight.trajectory->t_begin_s(),
               flight.trajectory->t_end_s());
  }
  const std::vector<std::filesystem::path> strips = FindStripFiles(flight.config.folder);
  if (!strips.empty()) SummariseStrips(strips, flight.config.strips_crs, &report);
  for (const auto& [reason, count] : flight.counts) {
    if (count > 0) fmt::print("note            {}: {}\n", reason, count);
  }
  report["counts"] = flight.counts;
  report["commands"] = Json::object();
  for (const CommandVerdict& verdict : Verdicts(flight, !strips.empty())) {
    fmt::print("dn {:<22} {}\n", verdict.command, verdict.possible ? "possible" : verdict.why);
    report["commands"][verdict.command] = {{"possible", verdict.possible}, {"why", verdict.why}};
  }
  run.AddFile("config.resolved.yaml", FormatFlightConfig(flight.config));
}

}  // namespace

void AddCheck(CLI::App* program, Action* action) {
  auto options = std::make_shared<Options>();
  CLI::App* app = program->add_subcommand(
      "check", "Validates a flight folder, summarises it, says what each command could do with it");
  app->add_option("FLIGHT", options->flight, "Flight folder, or the YAML file of a flight")
      ->required();
  AddCommonOptions(app, &options->common, false);
  app->footer("Example: dn check flight");
  app->callback([options, action] {
    *action = [options] {
      options->common.inputs = FlightInputs(options->flight);
      return Execute("check", options->common, [&](Run& run) { Check(*options, run); });
    };
  });
}

}  // namespace dn::apps
