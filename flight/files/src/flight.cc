#include <dn/error.h>
#include <dn/files/flight.h>
#include <dn/files/scanners.h>
#include <dn/geo/read_file.h>
#include <dn/geo/text_table.h>
#include <dn/geo/week_seconds.h>
#include <dn/parallel.h>
#include <dn/stopwatch.h>

#include <algorithm>

#include "is_there.h"
#include "pair_beams.h"
#include "pair_coverage.h"

namespace dn {
namespace {

// Inertial data bridge this time without GNSS positions.
constexpr double kGnssReach_s = 30.0;

using files_internal::CoveredTime;
namespace fs = std::filesystem;

bool IsFile(const fs::path& path) {
  std::error_code none;
  return fs::is_regular_file(path, none);
}

FileLocation MaxGapLocation(const fs::path& file) {
  if (!IsFile(file)) return {file.string()};
  const YamlValue root = ParseYaml(ReadWholeFile(file, kMaxYamlBytes), file.string());
  return root["imu"]["max_gap_s"].where();
}

GnssData ReadGnssFile(const FlightConfig& config) {
  const GnssConfig& gnss = *config.gnss;
  const GnssColumns columns{TextCoordinates(gnss.crs, config.origin, "gnss.crs"), gnss.grid_north,
                            gnss.columns, gnss.only_changed};
  return ReadGnss(config.folder / gnss.file, gnss.format, gnss.time_offset_s, columns);
}

/// Reads the parts of a flight folder into a Flight.
class FolderReader {
 public:
  FolderReader(FlightConfig config, const FlightNeeds& needs) : needs_(needs) {
    flight_.config = std::move(config);
  }

  Flight Read() {
    auto reference = Beside(needs_.threads, [this] { return ReadIfPresent("reference"); });
    if (needs_.imu) ReadImuPart();
    if (needs_.gnss) ReadGnssPart();
    if (needs_.trajectory) ReadTrajectoryPart();
    AlignStrips();
    if (needs_.pairs) ReadPairsPart();
    flight_.initial_guess = ReadIfPresent("initial_guess");
    flight_.reference = reference.get();
    flight_.frame = LocalFrame(Origin());
    if (gnss_) flight_.gnss = ToMap(*gnss_, flight_.frame);
    if (needs_.control && HasControl(flight_.config)) ReadControlPart();
    if (needs_.ties && !flight_.config.ties.empty()) ReadTiesPart();
    if (needs_.pairs) ReadSurfacesPart();
    return std::move(flight_);
  }

 private:
  fs::path InFolder(const fs::path& file) const { return flight_.config.folder / file; }

  /// Returns whether the section exists. Throws InvalidConfig if it is missing and reading is not
  /// optional.
  bool HasSection(bool present, const char* section) const {
    if (!present && !needs_.optional) {
      throw InvalidConfig(
          std::string("the section '") + section + "' is missing, and this command needs it",
          FileLocation{flight_.config.file.string(), 0, 0});
    }
    return present;
  }

  /// Returns whether a path with the name of the section's file exists. Throws InvalidInput if it
  /// is missing and reading is not optional. The reader of the file reports a path that is not a
  /// regular file.
  bool HasFile(const fs::path& path, const char* key) const {
    const bool present = files_internal::IsThere(path);
    if (!present && !needs_.optional) {
      throw InvalidInput("the data file " + path.string() + " does not exist; the key " + key +
                         " of flight.yaml gives its name");
    }
    return present;
  }

  void Count(const std::string& what, long count) {
    if (count != 0) flight_.counts[what] += count;
  }

  void ReadImuPart() {
    if (!HasSection(flight_.config.imu.has_value(), "imu")) return;
    const ImuConfig& imu = *flight_.config.imu;
    const fs::path file = InFolder(imu.file);
    if (!HasFile(file, "imu.file")) return;
    try {
      flight_.imu = ReadImu(file, imu.read);
    } catch (const InvalidConfig& e) {
      throw InvalidConfig(e.what(), MaxGapLocation(flight_.config.file));
    }
    if (flight_.imu->samples.empty()) {
      throw InvalidInput("no IMU sample lies inside time_span_s",
                         FileLocation{file.string(), 0, 0});
    }
    flight_.counts["imu samples"] = static_cast<long>(flight_.imu->samples.size());
    Count("imu repeated rows", flight_.imu->repeated_rows_dropped);
    Count("imu rows with the values of the row before", flight_.imu->repeated_values);
    Count("imu rows outside time span", flight_.imu->rows_outside_span);
    Count("imu gaps", static_cast<long>(flight_.imu->gaps.size()));
    Count("imu holes bridged", static_cast<long>(flight_.imu->bridges.size()));
  }

  void ReadGnssPart() {
    if (!HasSection(flight_.config.gnss.has_value(), "gnss")) return;
    const fs::path file = InFolder(flight_.config.gnss->file);
    if (!HasFile(file, "gnss.file")) return;
    GnssData gnss = ReadGnssFile(flight_.config);
    if (gnss.epochs.empty()) {
      throw InvalidInput("the GNSS file has no epochs", FileLocation{file.string(), 0, 0});
    }
    first_gnss_ = gnss.epochs.front().antenna;
    Count("gnss repeated rows", gnss.repeated_rows_dropped);
    Count("gnss sentences without a fix", gnss.unusable_sentences);
    for (const auto& [reason, rows] : gnss.counts) Count(reason, rows);
    KeepGnssInside(file, gnss);
    flight_.counts["gnss epochs"] = static_cast<long>(gnss.epochs.size());
    gnss_ = std::move(gnss);
  }

  void KeepGnssInside(const fs::path& file, GnssData& gnss) {
    if (const auto& span = flight_.config.time_span_s) {
      const CoveredTime covered{"time_span_s", span->x(), span->y(), {}};
      KeepGnssInside(covered, "gnss rows outside time span", file, gnss);
    }
    if (flight_.imu) {
      const CoveredTime covered = files_internal::Cover(*flight_.imu);
      KeepGnssInside(covered, "gnss rows outside imu data", file, gnss);
      Count("gnss rows in " + covered.gaps,
            static_cast<long>(std::erase_if(gnss.epochs, [&](const GnssEpoch& epoch) {
              return covered.GapAt(epoch.t_s) != nullptr;
            })));
      if (gnss.epochs.empty()) {
        throw InvalidInput(
            "every GNSS epoch lies in a gap of the IMU data; check the time systems of both files",
            {file.string()});
      }
    }
  }

  void KeepGnssInside(const CoveredTime& covered, const char* reason, const fs::path& file,
                      GnssData& gnss) {
    for (GnssEpoch& epoch : gnss.epochs) epoch.t_s = files_internal::AlignWeek(epoch.t_s, covered);
    const double t_begin_s = gnss.epochs.front().t_s;
    const double t_end_s = gnss.epochs.back().t_s;
    const std::size_t all = gnss.epochs.size();
    const double middle_s = gnss.epochs[all / 2].t_s;
    Count(reason, static_cast<long>(std::erase_if(gnss.epochs, [&](const GnssEpoch& epoch) {
            return !covered.InSpan(epoch.t_s);
          })));
    std::string unit;
    if (gnss.epochs.empty()) {
      unit = files_internal::ClockHint(middle_s, covered, "gnss");
    } else if (2 * gnss.epochs.size() < all) {
      unit = TimeUnitHint(middle_s, covered.t_begin_s, covered.t_end_s);
    }
    if (gnss.epochs.empty() || !unit.empty()) {
      throw InvalidInput(
          (gnss.epochs.empty() ? "no GNSS epoch lies inside " : "most GNSS epochs lie outside ") +
              covered.what + ": GNSS covers " + files_internal::SpanText(t_begin_s, t_end_s) +
              ", " + covered.what + " " +
              files_internal::SpanText(covered.t_begin_s, covered.t_end_s) +
              (unit.empty() ? "; both must be in GPS seconds of week" : unit),
          FileLocation{file.string(), 0, 0});
    }
  }

  /// Sets the trajectory file to that of the section, or to a default name that exists.
  void ResolveTrajectoryFile() {
    std::optional<TrajectoryConfig>& section = flight_.config.trajectory;
    const std::string usual = TrajectoryConfig().file;
    for (const std::string& name : {usual, std::string("trajectory.txt")}) {
      if (!files_internal::IsThere(InFolder(name))) continue;
      if (!section) section = TrajectoryConfig();
      if (section->file == usual) section->file = name;
      return;
    }
  }

  void ReadTrajectoryPart() {
    ResolveTrajectoryFile();
    if (!HasSection(flight_.config.trajectory.has_value(), "trajectory")) return;
    const fs::path file = InFolder(flight_.config.trajectory->file);
    if (!HasFile(file, "trajectory.file")) return;
    flight_.trajectory = ReadTrajectory(file, TextColumns(flight_.config));
    flight_.counts["trajectory points"] = static_cast<long>(flight_.trajectory->points().size());
    Count("trajectory repeated rows", flight_.trajectory->notes().repeated_rows_dropped);
  }

  /// Moves the strips of flight.yaml to the week of the data, like the pairs.
  void AlignStrips() {
    if (!flight_.imu && !flight_.trajectory) return;
    const CoveredTime covered = flight_.imu ? files_internal::Cover(*flight_.imu)
                                            : files_internal::Cover(*flight_.trajectory);
    for (StripInterval& strip : flight_.config.strips) {
      const double middle_s = 0.5 * (strip.t0_s + strip.t1_s);
      const double shift_s = files_internal::AlignWeek(middle_s, covered) - middle_s;
      strip.t0_s += shift_s;
      strip.t1_s += shift_s;
    }
  }

  /// Replaces the default name of the pair file by lidar/*.txt if there is no such file.
  void ResolvePairFiles() {
    std::vector<std::string>& patterns = flight_.config.lidar->p2p;
    const std::vector<std::string> usual = LidarConfig().p2p;
    if (patterns == usual && !files_internal::IsThere(InFolder(usual.front())) &&
        fs::is_directory(InFolder("lidar"))) {
      patterns = {"lidar/*.txt"};
    }
  }

  /// Returns whether every pattern matches a file.
  bool HasPairFiles(const std::vector<std::string>& patterns) const {
    try {
      FindPairFiles(flight_.config.folder, patterns);
      return true;
    } catch (const InvalidInput& e) {
      if (needs_.optional) return false;
      throw InvalidInput(std::string(e.what()) + "; check the key lidar.p2p of flight.yaml");
    }
  }

  /// Reads the pairs of every scanner, then those between two scanners.
  void ReadScannerPairs() {
    const FlightConfig& config = flight_.config;
    for (std::size_t k = 0; k < NumScanners(config); ++k) AddPairs(ScannerAt(config, k).p2p, k, k);
    for (const PairsBetween& between : config.pairs_between) {
      AddPairs(between.p2p, between.scanner_i, between.scanner_j);
    }
    if (needs_.optional || flight_.pairs) return;
    throw InvalidInput("no scanner has pair files; check the keys lidar.p2p and pairs_between",
                       FileLocation{config.file.string(), 0, 0});
  }

  /// Reads the pairs of two scanners. Pairs that `sigma_p_m` of the first scanner does not describe
  /// get their covariance.
  void AddPairs(const std::vector<std::string>& patterns, std::size_t i, std::size_t j) {
    if (patterns.empty() || !HasPairFiles(patterns)) return;
    const FlightConfig& config = flight_.config;
    const double offset_i_s = ScannerAt(config, i).time_offset_s;
    PairData data = ReadPairs(config.folder, patterns, offset_i_s);
    const double later_s = ScannerAt(config, j).time_offset_s - offset_i_s;
    for (LidarPair& pair : data.pairs) {
      if (later_s != 0.0) pair.t_j_s -= later_s;
      pair.scanner_i = static_cast<int>(i);
      pair.scanner_j = static_cast<int>(j);
      const double sigma_m = PairSigma(config, pair);
      if (i + j > 0 && !pair.covariance_m2) {
        pair.covariance_m2 = sigma_m * sigma_m * Eigen::Matrix3d::Identity();
      }
    }
    Append(std::move(data));
  }

  void Append(PairData data) {
    if (!flight_.pairs) {
      flight_.pairs = std::move(data);
      return;
    }
    PairData& all = *flight_.pairs;
    const int first = static_cast<int>(all.files.size());
    for (LidarPair& pair : data.pairs) pair.file += first;
    all.files.insert(all.files.end(), data.files.begin(), data.files.end());
    all.pairs.insert(all.pairs.end(), data.pairs.begin(), data.pairs.end());
    all.origins.insert(all.origins.end(), data.origins.begin(), data.origins.end());
    all.repeated_pairs_dropped += data.repeated_pairs_dropped;
  }

  /// Returns the pairs that lidar.pairs of their scanner selects; pairs between two scanners are
  /// all selected.
  std::vector<LidarPair> SelectScannerPairs(const std::vector<LidarPair>& pairs) const {
    if (NumScanners(flight_.config) == 1) return SelectPairs(pairs, flight_.config.lidar->pairs);
    std::vector<std::vector<LidarPair>> own(NumScanners(flight_.config));
    std::vector<LidarPair> between;
    for (const LidarPair& pair : pairs) {
      const bool same = pair.scanner_i == pair.scanner_j;
      (same ? own[static_cast<std::size_t>(pair.scanner_i)] : between).push_back(pair);
    }
    std::vector<LidarPair> selected;
    for (std::size_t k = 0; k < own.size(); ++k) {
      const auto some = SelectPairs(own[k], ScannerAt(flight_.config, k).pairs);
      selected.insert(selected.end(), some.begin(), some.end());
    }
    selected.insert(selected.end(), between.begin(), between.end());
    return selected;
  }

  void ReadPairsPart() {
    if (!HasSection(flight_.config.lidar.has_value(), "lidar")) return;
    ResolvePairFiles();
    ReadScannerPairs();
    if (!flight_.pairs) return;
    files_internal::CheckPairBeams(flight_.config, *flight_.pairs);
    Count("repeated pairs", flight_.pairs->repeated_pairs_dropped);
    KeepPairsInsideSpan();
    CheckPairsCovered();
    flight_.pair_strips = FindStrips(flight_);
    std::vector<LidarPair>& pairs = flight_.pairs->pairs;
    const std::size_t all = pairs.size();
    pairs = SelectScannerPairs(pairs);
    Count("pairs not selected", static_cast<long>(all - pairs.size()));
    flight_.counts["pairs"] = static_cast<long>(pairs.size());
  }

  void KeepPairsInsideSpan() {
    const auto& span = flight_.config.time_span_s;
    if (!span) return;
    const CoveredTime covered{"time_span_s", span->x(), span->y(), {}};
    std::vector<LidarPair>& pairs = flight_.pairs->pairs;
    files_internal::AlignWeek(covered, pairs);
    const auto dropped = std::erase_if(pairs, [&](const LidarPair& pair) {
      return !covered.Contains(pair.t_i_s) || !covered.Contains(pair.t_j_s);
    });
    Count("pairs outside time span", static_cast<long>(dropped));
    if (pairs.empty()) {
      throw InvalidInput("no lidar pair lies inside time_span_s (" +
                             files_internal::SpanText(span->x(), span->y()) + ")",
                         FileLocation{flight_.pairs->files.front().string(), 0, 0});
    }
  }

  /// Requires that pairs are inside the data that were read, and drops those in gaps. With optional
  /// reading they must be inside one of the two data sets, and both cases are only counted.
  void CheckPairsCovered() {
    std::vector<CoveredTime> coverages;
    if (flight_.imu) coverages.push_back(files_internal::Cover(*flight_.imu));
    if (flight_.trajectory) coverages.push_back(files_internal::Cover(*flight_.trajectory));
    if (coverages.empty()) return;
    PairData& pairs = *flight_.pairs;
    files_internal::AlignWeek(coverages.front(), pairs.pairs);
    std::size_t complete = 0;
    for (const CoveredTime& covered : coverages) {
      if (!needs_.optional) {
        files_internal::ExpectInSpan(pairs, covered);
        Count("pairs in " + covered.gaps, files_internal::DropInGaps(covered, pairs));
        continue;
      }
      const long outside = files_internal::CountOutside(pairs, covered);
      Count("pairs outside " + covered.what, outside);
      Count("pairs in " + covered.gaps, files_internal::CountInGaps(pairs, covered));
      if (outside == 0) ++complete;
    }
    if (needs_.optional && complete == 0) files_internal::ExpectInSpan(pairs, coverages.front());
    if (flight_.imu && gnss_ && !gnss_->epochs.empty()) CheckPairsNearGnss(pairs);
  }

  /// Requires that some pairs are near GNSS positions: far from any, an inertial trajectory drifts
  /// by kilometres.
  void CheckPairsNearGnss(const PairData& pairs) {
    const CoveredTime near{"GNSS",
                           gnss_->epochs.front().t_s - kGnssReach_s,
                           gnss_->epochs.back().t_s + kGnssReach_s,
                           {}};
    const long outside = files_internal::CountOutside(pairs, near);
    Count("pairs far from GNSS", outside);
    if (needs_.optional || pairs.pairs.empty() || outside < static_cast<long>(pairs.pairs.size()))
      return;
    const auto [first, last] = std::ranges::minmax_element(pairs.pairs, {}, &LidarPair::t_i_s);
    throw InvalidInput(
        "GNSS covers " +
            files_internal::SpanText(near.t_begin_s + kGnssReach_s, near.t_end_s - kGnssReach_s) +
            ", but the pairs lie at " + files_internal::SpanText(first->t_i_s, last->t_i_s) +
            ": nothing determines the trajectory there; give the GNSS data of that time",
        FileLocation{pairs.files.front().string(), 0, 0});
  }

  void ReadControlPart() {
    ControlData control = ReadControl(flight_.config, flight_.frame);
    ExpectControlNear(control, FlownPositions(), flight_.frame, ControlCrs(flight_.config));
    if (flight_.imu) KeepReturnsCovered(files_internal::Cover(*flight_.imu), &control);
    for (const ControlPoint& point : control.points) {
      ++flight_.counts[point.is_check ? "control checks" : "control observations"];
    }
    flight_.control = std::move(control);
  }

  /// Requires that returns on control are inside the data, and drops those in gaps.
  void KeepReturnsCovered(const CoveredTime& covered, ControlData* control) {
    for (ControlPoint& point : control->points) {
      for (ControlReturn& one : point.returns) {
        one.t_s = files_internal::AlignWeek(one.t_s, covered);
        if (covered.InSpan(one.t_s)) continue;
        throw InvalidInput("the epoch " + FormatDouble(one.t_s) + " s of point '" + point.name +
                               "' lies outside " + covered.what + " (" +
                               files_internal::SpanText(covered.t_begin_s, covered.t_end_s) + ")" +
                               files_internal::ClockHint(one.t_s, covered, "lidar"),
                           one.where);
      }
      Count("control returns in " + covered.gaps,
            static_cast<long>(std::erase_if(point.returns, [&](const ControlReturn& one) {
              return covered.GapAt(one.t_s) != nullptr;
            })));
    }
  }

  /// Drops the returns on tie points that are outside the IMU data or in their gaps.
  void ReadTiesPart() {
    TieData ties = ReadTies(flight_.config);
    long inside = 0;
    if (flight_.imu) {
      const CoveredTime covered = files_internal::Cover(*flight_.imu);
      for (ControlPoint& point : ties.points.points) {
        ControlReturn& one = point.returns.front();
        one.t_s = files_internal::AlignWeek(one.t_s, covered);
        if (covered.Contains(one.t_s)) {
          ++inside;
        } else {
          point.returns.clear();
        }
      }
    }
    if (inside == 0) {
      throw InvalidInput(
          "no epoch of these pairs lies in the IMU data of this flight; check the key end of ties",
          FileLocation{ties.points.files.front().string(), 0, 0});
    }
    flight_.counts["tie points"] = inside;
    Count("tie points outside the IMU data", static_cast<long>(ties.points.points.size()) - inside);
    flight_.ties = std::move(ties);
  }

  void ReadSurfacesPart() {
    ControlData surfaces = ReadSurfaces(flight_.config);
    if (surfaces.points.empty()) return;
    std::vector<CoveredTime> coverages;
    if (const auto& span = flight_.config.time_span_s) {
      coverages.push_back({"time_span_s", span->x(), span->y(), {}});
    }
    if (flight_.imu) coverages.push_back(files_internal::Cover(*flight_.imu));
    for (const CoveredTime& covered : coverages) {
      const auto is_outside = [&](ControlReturn& one) {
        one.t_s = files_internal::AlignWeek(one.t_s, covered);
        return !covered.Contains(one.t_s);
      };
      const auto dropped = std::erase_if(surfaces.points, [&](ControlPoint& plane) {
        return std::ranges::any_of(plane.returns, is_outside);
      });
      Count("surface pairs outside " + covered.what, static_cast<long>(dropped));
    }
    if (surfaces.points.empty()) {
      throw InvalidInput("no surface pair lies inside the data of the flight",
                         FileLocation{surfaces.files.front().string(), 0, 0});
    }
    flight_.counts["surface pairs"] = static_cast<long>(surfaces.points.size());
    flight_.surfaces = std::move(surfaces);
  }

  /// Returns positions of the flight in map: GNSS epochs, or else points of the trajectory.
  std::vector<Eigen::Vector3d> FlownPositions() const {
    constexpr std::size_t kEnough = 500;
    std::vector<Eigen::Vector3d> flown_m;
    if (flight_.gnss) {
      const std::size_t step = 1 + flight_.gnss->epochs.size() / kEnough;
      for (std::size_t k = 0; k < flight_.gnss->epochs.size(); k += step) {
        flown_m.push_back(flight_.gnss->epochs[k].p_m);
      }
    } else if (flight_.trajectory) {
      const std::vector<NavPoint>& points = flight_.trajectory->points();
      for (std::size_t k = 0; k < points.size(); k += 1 + points.size() / kEnough) {
        flown_m.push_back(flight_.frame.ToMap(points[k].position));
      }
    }
    return flown_m;
  }

  std::optional<Trajectory> ReadIfPresent(const std::string& stem) const {
    for (const char* extension : {".out", ".txt"}) {
      const fs::path file = InFolder(stem + extension);
      if (files_internal::IsThere(file)) {
        return ReadTrajectory(file, {.body_is_flu = flight_.config.body_is_flu});
      }
    }
    return std::nullopt;
  }

  /// Returns the same origin for all FlightNeeds, so that all commands share one map frame.
  Geodetic Origin() const {
    const FlightConfig& config = flight_.config;
    if (config.origin) return *config.origin;
    if (first_gnss_) return *first_gnss_;
    if (config.gnss && IsFile(InFolder(config.gnss->file))) {
      const GnssData gnss = ReadGnssFile(config);
      if (!gnss.epochs.empty()) return gnss.epochs.front().antenna;
    }
    if (flight_.trajectory) return flight_.trajectory->points().front().position;
    return {};
  }

  FlightNeeds needs_;
  Flight flight_;
  std::optional<GnssData> gnss_;
  std::optional<Geodetic> first_gnss_;
};

}  // namespace

Flight ReadFlight(const FlightConfig& config, const FlightNeeds& needs) {
  const Stopwatch watch;
  Flight flight = FolderReader(config, needs).Read();
  flight.read_time_s = watch.seconds();
  return flight;
}

Flight ReadFlight(const fs::path& folder, const FlightNeeds& needs) {
  return ReadFlight(ReadFlightConfig(folder), needs);
}

}  // namespace dn
