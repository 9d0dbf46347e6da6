#include "read_anything.h"

#include <dn/blind_check/blind_record.h>
#include <dn/error.h>
#include <dn/files/file_content.h>
#include <dn/files/flight_config.h>
#include <dn/geo/text_table.h>
#include <dn/geo/trajectory.h>
#include <dn/geo/trajectory_covariance.h>
#include <dn/geo/week_seconds.h>
#include <dn/gnss/gnss_data.h>
#include <dn/imu/imu_data.h>
#include <dn/lidar/pairs.h>
#include <dn/lidar/strip_io.h>
#include <dn/lidar/surface_pairs.h>
#include <dn/montecarlo/flight_record.h>
#include <dn/report/json_reader.h>
#include <dn/sim/scenario.h>
#include <dn/study/sweep.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace dn::testing {
namespace {

namespace fs = std::filesystem;

/// A folder that exists as long as the program, in memory if the system has a file system for that.
class ScratchFolder {
 public:
  ScratchFolder() {
    const fs::path base = fs::exists("/dev/shm") ? fs::path("/dev/shm") : fs::temp_directory_path();
    path_ = base / ("dn_fuzz_" + std::to_string(getpid()));
    fs::create_directories(path_);
  }
  ~ScratchFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  fs::path Write(const char* name, std::string_view content) const {
    fs::path file = path_ / name;
    std::ofstream(file, std::ios::binary)
        .write(content.data(), static_cast<std::streamsize>(content.size()));
    return file;
  }
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

void Require(bool holds, const char* promise) {
  if (holds) return;
  std::fprintf(stderr, "broken promise: %s\n", promise);
  std::abort();
}

template <class Items>
void RequireIncreasingTimes(const Items& items) {
  for (std::size_t i = 0; i < items.size(); ++i) {
    Require(std::isfinite(items[i].t_s), "times are finite");
    Require(i == 0 || items[i].t_s > items[i - 1].t_s, "times increase");
  }
}

void CheckTable(const fs::path& file) {
  const TextTable table = ReadTextTable(file, {});
  Require(table.rows() > 0 && table.columns > 0, "a table has rows and columns");
  Require(table.values.size() == table.rows() * table.columns, "rows x columns values");
  for (const double value : table.values) Require(std::isfinite(value), "values are finite");
}

void CheckTrajectory(const fs::path& file) {
  const Trajectory trajectory = ReadTrajectory(file);
  RequireIncreasingTimes(trajectory.points());
  for (const NavPoint& point : trajectory.points()) {
    Require(std::abs(point.q_nb.norm() - 1.0) < 1e-9, "quaternions are unit");
    Require(point.v_ned_mps.allFinite(), "velocities are finite");
  }
}

void CheckImu(const fs::path& file, ImuFormat format) {
  ImuReadOptions options;
  options.format = format;
  const ImuData imu = ReadImu(file, options);
  RequireIncreasingTimes(imu.samples);
  for (const ImuSample& sample : imu.samples) {
    Require(sample.dt_s > 0.0, "intervals are positive");
    Require(sample.w_ib_b_radps.allFinite() && sample.f_b_mps2.allFinite(), "samples are finite");
  }
}

void CheckGnss(const fs::path& file, GnssFormat format) {
  const GnssData gnss = ReadGnss(file, format);
  RequireIncreasingTimes(gnss.epochs);
  for (const GnssEpoch& epoch : gnss.epochs) {
    Require(std::isfinite(epoch.antenna.lat_rad) && std::isfinite(epoch.antenna.lon_rad) &&
                std::isfinite(epoch.antenna.h_m),
            "positions are finite");
    Require(!epoch.covariance_enu_m2 || epoch.covariance_enu_m2->allFinite(),
            "covariances are finite");
  }
}

void CheckPairs(const fs::path& folder) {
  const PairData data = ReadPairs(folder, {"LiDAR_p2p.txt"});
  Require(!data.pairs.empty(), "there are pairs");
  for (const LidarPair& pair : data.pairs) {
    Require(pair.u_i_s.allFinite() && pair.u_i_s.norm() > 0.0, "laser vectors are not zero");
    Require(pair.u_j_s.allFinite() && pair.u_j_s.norm() > 0.0, "laser vectors are not zero");
  }
}

void CheckSurfacePairs(const fs::path& folder) {
  for (const SurfacePair& pair : ReadSurfacePairs(folder, {"surfaces.txt"}).pairs) {
    Require(pair.ends.u_i_s.norm() > 0.0, "laser vectors are not zero");
    Require(std::abs(pair.normal_m.norm() - 1.0) < 1e-9, "normals are unit");
    Require(pair.sigma_m > 0.0, "standard deviations are positive");
  }
}

void CheckPoints(const StripCloud& points) {
  Require(!points.p_c.empty(), "a chunk has points");
  for (const Eigen::Vector3d& p_c : points.p_c) Require(p_c.allFinite(), "coordinates are finite");
  for (const double t_s : points.t_s) Require(IsWeekSeconds(t_s), "times are seconds of week");
  for (const Eigen::Vector3d& u_s : points.u_s) {
    Require(u_s.allFinite() && u_s.norm() > 0.0, "laser vectors are not zero");
  }
}

void CheckStrip(const fs::path& file) {
  const auto reader = OpenStrip(file);
  const fs::path copy = fs::path(file).replace_filename("copy" + file.extension().string());
  const auto writer = reader->MakeWriter(
      copy, {.covariance = true, .boresight_rad = Eigen::Vector3d(0.1, 0.2, 0.3)});
  std::size_t read = 0;
  for (StripCloud points; reader->Next(&points); read += points.size()) {
    CheckPoints(points);
    points.covariance_c_m2.assign(points.size(), Eigen::Matrix3d::Identity());
    writer->Append(points);
  }
  writer->Finish();
  const auto again = OpenStrip(copy);
  std::size_t written = 0;
  for (StripCloud points; again->Next(&points);) written += points.size();
  Require(written == read, "every point is written");
}

void CheckTrajectoryCovariance(const fs::path& file) {
  const TrajectoryCovariance read = ReadTrajectoryCovariance(file);
  Require(!read.t_s.empty(), "there are epochs");
  Require(read.covariance.diagonal().minCoeff() > 0.0, "variances are positive");
}

void CheckScenario(const std::string& yaml) {
  const Scenario scenario = ParseScenario(yaml, "scenario.yaml");
  Require(!scenario.plan.lines.empty() || scenario.plan.replay, "there is a path to fly");
  Require(scenario.imu.rate_hz > 0.0 && scenario.gnss.rate_hz > 0.0, "rates are positive");
  Require(scenario.pairs.sigma_p_m > 0.0, "the sigma of the pairs is positive");
}

void CheckJson(std::string_view text) {
  const Json json = ParseJson(text, "file.json");
  const JsonLimits limits;
  Require(CountValues(json) <= limits.values, "values are bounded");
  Require(json == ParseJson(json.dump(), "again.json"), "what was read is written and read back");
}

/// Requires that a record reads back as it was written.
template <class Read>
void CheckRecord(std::string_view text, const Read& read) {
  const Json json = ParseJson(text, "record.json");
  const std::string written = ToJson(read(JsonPlace(json, "record.json"))).dump();
  const Json again = ParseJson(written, "again.json");
  Require(ToJson(read(JsonPlace(again))).dump() == written, "a record is written and read back");
}

/// Returns the text without its leading comment, which states the body frame of the input.
std::string WithoutComment(const std::string& yaml) {
  return yaml.starts_with('#') ? yaml.substr(yaml.find('\n') + 1) : yaml;
}

void CheckConfig(const ScratchFolder& scratch) {
  const std::string resolved = FormatFlightConfig(ReadFlightConfig(scratch.path()));
  scratch.Write("flight.yaml", resolved);
  try {
    const std::string again = FormatFlightConfig(ReadFlightConfig(scratch.path()));
    if (WithoutComment(resolved) == WithoutComment(again)) return;
    std::fprintf(stderr, "%s\nreads back as\n%s\n", resolved.c_str(), again.c_str());
    Require(false, "a configuration reads back as it was written");
  } catch (const InvalidInput& e) {
    std::fprintf(stderr, "%s\n%s\n", e.what(), resolved.c_str());
    Require(false, "a written configuration is accepted");
  }
}

/// Reads positions with the columns that were found.
void CheckFoundGnss(const FileContent& content) {
  if (content.kind != FileKind::kGnss || content.columns.empty()) return;
  GnssColumns columns;
  columns.names = content.columns;
  columns.only_changed = content.only_changed;
  try {
    ReadGnss(content.file, content.gnss_format, content.time_offset_s, columns);
  } catch (const InvalidInput&) {  // a later row may be wrong
    return;
  }
}

/// Looks at a file of any content, and reads the positions in it.
void CheckContent(const fs::path& file) {
  InspectFile(file);
  for (const FileContent& content : InspectFolder(file.parent_path())) {
    if (content.file == file) CheckFoundGnss(content);
  }
}

void Read(char reader, std::string_view content) {
  static const ScratchFolder scratch;
  switch (reader) {
    case 'T':
      CheckContent(scratch.Write("data.out", content));  // accepts everything
      return CheckTable(scratch.Write("table.txt", content));
    case 'S':
      return CheckTrajectory(scratch.Write("trajectory.out", content));
    case 'O':
      return CheckTrajectory(scratch.Write("trajectory.txt", content));
    case 'I':
      return CheckImu(scratch.Write("IMU.txt", content), ImuFormat::kOdyn);
    case 'J':
      return CheckImu(scratch.Write("IMU.txt", content), ImuFormat::kIncrements);
    case 'G':
      return CheckGnss(scratch.Write("GPS.txt", content), GnssFormat::kOdyn);
    case 'R':
      return CheckGnss(scratch.Write("GPS.txt", content), GnssFormat::kRtklib);
    case 'B':
      return CheckGnss(scratch.Write("GPS.txt", content), GnssFormat::kObGins);
    case 'N':
      return CheckGnss(scratch.Write("GPS.txt", content), GnssFormat::kNmea);
    case 'P':
      scratch.Write("LiDAR_p2p.txt", content);
      return CheckPairs(scratch.path());
    case 'H':
      scratch.Write("surfaces.txt", content);
      return CheckSurfacePairs(scratch.path());
    case 'C':
      return CheckScenario(std::string(content));
    case 'V':
      return CheckTrajectoryCovariance(scratch.Write("trajectory_covariance.txt", content));
    case 'L':
      return CheckStrip(scratch.Write("strip.las", content));
    case 'X':
      return CheckStrip(scratch.Write("strip.txt", content));
    case 'M':
      return CheckJson(content);
    case 'D':
      return CheckRecord(content, &FlightRecordFromJson);
    case 'W':
      return CheckRecord(content, &SweepRecordFromJson);
    case 'E':
      return CheckRecord(content, &BlindRecordFromJson);
    default:
      scratch.Write("flight.yaml", content);
      return CheckConfig(scratch);
  }
}

}  // namespace

std::string ReadAnything(const unsigned char* data, std::size_t size) {
  if (size == 0) return "no reader";
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const bool named = kReaders.find(bytes[0]) != std::string_view::npos;
  const char reader = named ? bytes[0] : kReaders[data[0] % kReaders.size()];
  try {
    Read(reader, bytes.substr(1));
  } catch (const InvalidInput& e) {
    std::string message = e.what();
    Require(!message.empty(), "a rejection says why");
    return message;
  }
  return {};
}

}  // namespace dn::testing
