#include "flight_draft.h"

#include <dn/error.h>
#include <dn/files/flight.h>
#include <dn/files/strip_files.h>
#include <dn/files/yaml_sections.h>
#include <dn/geo/text_table.h>
#include <dn/imu/unit_agreement.h>
#include <dn/imu/white_rows.h>
#include <dn/report/value_words.h>
#include <dn/rotation.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "data_hints.h"
#include "logged_attitudes.h"
#include "nmea_sigmas.h"
#include "scanner_draft.h"
#include "strip_hints.h"
#include "trajectory_hints.h"

namespace dn::apps {
namespace {

namespace fs = std::filesystem;

constexpr double kSqrtHourPerSqrtS = 1.0 / 60.0;
// The stated noise is this factor times the noise of the data.
constexpr double kWhiteMargin = 1.5;
// Sigma of a lever arm that nobody stated: antennas and scanners are mounted within a metre.
constexpr double kLeverArmSigmaM = 0.5;
// Logs filter their attitudes. A smaller offset is left to the positions.
constexpr double kAttitudeClockS = 0.3;
constexpr const char* kDefaultImu = "IMU.txt";
constexpr const char* kDefaultGnss = "GPS.txt";

/// Assumed biases of a sensor class, which is chosen by the white noise. The values are wide.
struct BiasClass {
  double max_white_deg_sqrt_h;
  const char* name;
  const char* gyro;
  const char* accel;
};

constexpr BiasClass kClasses[] = {
    {0.02, "navigation or high tactical grade",
     "{type: random_constant, sigma_deg_h: 3}, {type: gauss_markov, sigma_deg_h: 0.3, tau_s: 300}",
     "{type: random_constant, sigma_mg: 2}, {type: gauss_markov, sigma_mg: 0.1, tau_s: 300}"},
    {0.15, "tactical grade",
     "{type: random_constant, sigma_deg_h: 60}, {type: gauss_markov, sigma_deg_h: 6, tau_s: 300}",
     "{type: random_constant, sigma_mg: 10}, {type: gauss_markov, sigma_mg: 0.5, tau_s: 300}"},
    {1e9, "MEMS grade",
     "{type: random_constant, sigma_deg_h: 1000}, {type: gauss_markov, sigma_deg_h: 100, tau_s: "
     "100}",
     "{type: random_constant, sigma_mg: 50}, {type: gauss_markov, sigma_mg: 3, tau_s: 100}"}};

const BiasClass& FindBiasClass(double white_deg_sqrt_h) {
  return *std::find_if(std::begin(kClasses), std::end(kClasses), [&](const BiasClass& c) {
    return white_deg_sqrt_h <= c.max_white_deg_sqrt_h;
  });
}

const char* GnssFormatWord(GnssFormat format) {
  switch (format) {
    case GnssFormat::kOdyn:
      break;
    case GnssFormat::kRtklib:
      return "rtklib";
    case GnssFormat::kObGins:
      return "ob_gins";
    case GnssFormat::kNmea:
      return "nmea";
  }
  return "odyn";
}

bool IsInGrid(const FileContent& file) { return file.trajectory && file.trajectory->crs == "utm:"; }

std::string FindUtmZone(const Geodetic& place) {
  const double lon_deg = place.lon_rad * kDegPerRad;
  const int zone = static_cast<int>(std::floor((lon_deg + 180.0) / 6.0)) % 60 + 1;
  return fmt::format("{}{}", zone, place.lat_rad < 0.0 ? 's' : 'n');
}

/// Formats a number with two digits.
std::string Short(double value) { return fmt::format("{:.2g}", value); }

std::string ImuSummary(const ImuData& imu) {
  return fmt::format("{:.3f} .. {:.3f} s, {:.2f} Hz, {}, jitter up to {:.1f} ms, {} gaps",
                     imu.t_begin_s(), imu.t_end_s(), 1.0 / imu.nominal_dt_s,
                     imu.uneven ? "uneven" : "even", 1e3 * imu.max_jitter_s, imu.gaps.size());
}

std::string GnssSummary(const MapGnss& gnss) {
  const double begin_s = gnss.epochs.front().t_s, end_s = gnss.epochs.back().t_s;
  const double rate_hz =
      static_cast<double>(gnss.epochs.size() - 1) / std::max(end_s - begin_s, 1e-3);
  return fmt::format("{:.3f} .. {:.3f} s, {} epochs, {:.2f} Hz", begin_s, end_s, gnss.epochs.size(),
                     rate_hz);
}

std::string OffsetText(double offset_s) {
  std::string text = fmt::format("  time_offset_s: {}", FormatDouble(offset_s));
  if (std::abs(offset_s) > 1e6) text += "   # the tags are seconds since 1980 or 1970; removed";
  return text + "\n";
}

bool HasBeams(const TextTable& pairs) { return pairs.columns == 10 || pairs.columns == 16; }

/// Returns the number of beams that the pairs of a file with beams name.
std::size_t CountBeams(const std::filesystem::path& file) {
  double largest = kNoBeam;
  TextTableReader reader(file, {});
  while (reader.Next(10000)) {
    const TextTable& table = reader.table();
    for (std::size_t i = 0; i < table.rows(); ++i) {
      const double* row = table.row(i);
      largest = std::max({largest, row[table.columns - 2], row[table.columns - 1]});
    }
  }
  return largest >= 0.0 && largest < kMostBeams ? static_cast<std::size_t>(largest) + 1 : 0;
}

/// Returns the names in a list like that of FormatColumnNames.
ColumnNames ParseColumnNames(const std::string& list) {
  ColumnNames names;
  std::string name;
  for (const char c : list) {
    if (c == '[' || c == ' ') continue;
    if (c != ',' && c != ']') {
      name += c;
      continue;
    }
    names.push_back(std::exchange(name, {}));
  }
  return names;
}

/// Returns whether latitude comes before longitude, as in the documented columns.
bool LatitudeFirst(const ColumnNames& names) {
  for (const std::string& name : names) {
    if (HasColumn({name}, "lat")) return true;
    if (HasColumn({name}, "lon")) return false;
  }
  return true;
}

bool LacksVectors(const fs::path& file) {
  try {
    const auto strip = OpenStrip(file);
    return !strip->has_vectors() && !strip->boresight_rad();
  } catch (const InvalidInput&) {  // the commands that read strips report it
    return false;
  }
}

std::size_t CountWithoutVectors(const std::vector<StripScanner>& scanners) {
  std::ptrdiff_t count = 0;
  for (const StripScanner& scanner : scanners) {
    count += std::ranges::count_if(scanner.strips, LacksVectors);
  }
  return static_cast<std::size_t>(count);
}

std::string ColumnNamesText(const FileContent& content) {
  if (content.columns.empty()) return {};
  return fmt::format("  columns: {}   # in the order of the file\n",
                     FormatColumnNames(content.columns));
}

/// Describes the relation of a second inertial unit to the one in use.
std::string UnitsText(const std::string& used, const std::string& other,
                      const std::optional<UnitAgreement>& found) {
  if (!found) {
    return other + " and " + used + " do not show the same rotations at any offset of their clocks";
  }
  const Eigen::Vector3d turn_deg = kDegPerRad * Log(found->q_ba);
  const Eigen::Vector3d sigma_deg = kDegPerRad * found->sigma_rotation_rad;
  return fmt::format(
      "{} shows the rotations of {}: its tags are {} s {} and drift by {} ppm, and its axes are "
      "turned by {}, {}, {} deg about x, y, z; the two {} (variance ratio {:.2f}, p = {:.2g})",
      other, used, FormatWithSigma(std::abs(found->offset_s), found->sigma_offset_s),
      found->offset_s < 0.0 ? "early" : "late",
      FormatWithSigma(1e6 * found->drift, 1e6 * found->sigma_drift),
      FormatWithSigma(turn_deg[0], sigma_deg[0]), FormatWithSigma(turn_deg[1], sigma_deg[1]),
      FormatWithSigma(turn_deg[2], sigma_deg[2]),
      found->p_value < 1e-3 ? "differ by more than their noise" : "agree within their noise",
      found->variance_ratio, found->p_value);
}

/// Says that sigmas of the GNSS positions are missing, or where the file states them.
std::string MissingSigma(const FileContent& gnss, const NmeaQualities& qualities) {
  if (!gnss.accuracy.empty()) {
    return "gnss.sigma_enu_m: the file states an accuracy in " + gnss.accuracy +
           ", but not those of east, north and up: give them in m";
  }
  return "gnss.sigma_enu_m: the file states no sigmas of its positions" +
         MixedQualitiesText(qualities);
}

}  // namespace

FlightDraft::FlightDraft(fs::path folder, const std::vector<FileContent>& contents)
    : folder_(std::move(folder)),
      strip_scanners_(FindStripFolders(folder_)),
      strips_without_vectors_(CountWithoutVectors(strip_scanners_)) {
  for (const FileContent& content : contents) Take(content);
}

std::string FlightDraft::Named(const fs::path& file) const {
  return file.lexically_relative(folder_).generic_string();
}

void FlightDraft::TakeOne(const FileContent& content, const char* usual,
                          std::optional<FileContent>* place) {
  // A file of its own comes before a table of several sensors.
  const bool own = *place && (*place)->only_changed && !content.only_changed;
  const bool better = own || (*place && Named(content.file) == usual);
  if (*place) {
    others_.push_back(better ? **place : content);
  }
  if (!*place || better) *place = content;
}

void FlightDraft::Take(const FileContent& content) {
  const std::string name = Named(content.file);
  if (content.kind != FileKind::kUnknown && !content.why.empty()) {
    notes_.push_back(name + ": " + content.why);
  }
  switch (content.kind) {
    case FileKind::kImu:
      TakeOne(content, kDefaultImu, &imu_);
      break;
    case FileKind::kGnss:
      TakeOne(content, kDefaultGnss, &gnss_);
      break;
    case FileKind::kTrajectory:
      TakeOne(content, "trajectory.out", &trajectory_);
      break;
    case FileKind::kSmrmsg:
      TakeOne(content, "", &smrmsg_);
      break;
    case FileKind::kPairs:
      pairs_.push_back(content);
      break;
    case FileKind::kPointCloud:
      notes_.push_back(name + " is a point cloud: move point clouds of strips to strips/");
      break;
    case FileKind::kUnknown:
      notes_.push_back(name + " is not used: " + content.why);
      break;
  }
}

void FlightDraft::TakeReadable(FileKind kind, std::optional<FileContent>* place) {
  while (*place) {
    try {
      const std::string text = kind == FileKind::kImu ? ImuText() : GnssText();
      ReadFlight(ParseFlightConfig(text, folder_),
                 {.imu = kind == FileKind::kImu, .gnss = kind == FileKind::kGnss});
      return;
    } catch (const InvalidInput& error) {
      const FileLocation& where = error.where();
      const std::string line = where.line > 0 ? fmt::format(" (line {})", where.line) : "";
      const std::string name = Named((*place)->file);
      std::erase(notes_, name + ": " + (*place)->why);
      notes_.push_back(fmt::format("{} is not used: {}{}", name, error.what(), line));
      rejected_.push_back(**place);
      place->reset();
    }
    const auto next = std::ranges::find(others_, kind, &FileContent::kind);
    if (next == others_.end()) return;
    *place = *next;
    (kind == FileKind::kImu ? imu_offset_s_ : gnss_offset_s_) = next->time_offset_s;
    others_.erase(next);
  }
}

void FlightDraft::NoteOthers() {
  for (const FileContent& other : others_) {
    const auto note = [&](const char* what, const std::optional<FileContent>& used) {
      notes_.push_back(fmt::format("{} also contains {}; {} is used", Named(other.file), what,
                                   Named(used->file)));
    };
    if (other.kind == FileKind::kImu) note("inertial data", imu_);
    if (other.kind == FileKind::kGnss) note("GNSS data", gnss_);
    if (other.kind == FileKind::kTrajectory) note("a trajectory", trajectory_);
    if (other.kind == FileKind::kSmrmsg) note("standard deviations", smrmsg_);
  }
}

bool FlightDraft::Rejected(const FileContent& content) const {
  return std::ranges::any_of(rejected_, [&](const FileContent& each) {
    return each.file == content.file && each.kind == content.kind;
  });
}

void FlightDraft::Settle() {
  if (imu_) imu_offset_s_ = imu_->time_offset_s;
  if (gnss_) gnss_offset_s_ = gnss_->time_offset_s;
  TakeReadable(FileKind::kImu, &imu_);
  TakeReadable(FileKind::kGnss, &gnss_);
  NoteOthers();
  if (gnss_ && gnss_->gnss_format == GnssFormat::kNmea) {
    nmea_qualities_ = CountNmeaQualities(gnss_->file);
  }
  SettleByAttitudes();
  try {
    SettleSensors();
  } catch (const InvalidInput& error) {
    axes_notes_.push_back(std::string("inertial and GNSS data do not fit each other: ") +
                          error.what());
  }
  CompareOtherUnits();
  SettleTrajectory();
  SettleScanner();
  CompareStrips();
}

void FlightDraft::CompareStrips() {
  if (strip_scanners_.size() != 1 || !trajectory_notes_.empty()) return;
  try {
    const FlightConfig config = ParseFlightConfig(Text(), folder_);
    const Flight flight = ReadFlight(config, {.gnss = true, .trajectory = true, .optional = true});
    const std::optional<RoughPath> path = KnownPath(flight);
    if (!path) return;
    for (const fs::path& file : strip_scanners_.front().strips) {
      // The mounting is not known yet, so that the vectors say nothing.
      const auto found = CompareStrip(file, config, *path, false);
      using Kind = StripDisagreement::Kind;
      if (!found || (found->kind != Kind::kClock && found->kind != Kind::kOutside)) continue;
      strip_notes_.push_back(Named(file) + ": " +
                             StripDisagreementText(*found, config.lidar->time_offset_s));
    }
  } catch (const InvalidInput&) {  // the zone of a grid is missing
    return;
  }
}

void FlightDraft::CompareOtherUnits() {
  if (!imu_) return;
  const FileContent used = *imu_;
  const auto read = [&](const FileContent& content) {
    imu_ = content;
    return ReadFlight(ParseFlightConfig(ImuText(), folder_), {.imu = true, .gnss = false});
  };
  for (const FileContent& other : others_) {
    if (other.kind != FileKind::kImu) continue;
    try {
      const Flight a = read(used), b = read(other);
      found_.push_back(
          UnitsText(Named(used.file), Named(other.file), CompareUnits(*a.imu, *b.imu)));
    } catch (const InvalidInput& error) {
      notes_.push_back(Named(other.file) +
                       " cannot be compared with the other inertial data: " + error.what());
    }
  }
  imu_ = used;
}

void FlightDraft::SettleByAttitudes() {
  if (!imu_ || !gnss_ || gnss_offset_s_ != 0.0) return;
  const std::optional<LoggedAttitudes> log = CompareLoggedAttitudes(*gnss_, ImuText(), folder_);
  if (!log) return;
  found_.push_back(log->Text(Named(gnss_->file), Named(imu_->file)));
  if (std::abs(log->offset_s) > kAttitudeClockS) {
    gnss_offset_s_ = std::round(1e3 * log->offset_s) / 1e3;
  }
  if (!log->HasParallelAxes()) return;
  R_imu_to_body_ = log->R_axes * R_imu_to_body_;
  axes_by_attitudes_ = true;
}

bool FlightDraft::SettleByHint(const DataHint& hint, const DataAgreement& agreement) {
  if (hint.key == "imu.time_offset_s") {
    imu_offset_s_ = std::stod(hint.value);
  } else if (hint.key == "gnss.time_offset_s") {
    gnss_offset_s_ = std::stod(hint.value);
  } else if (hint.key == "imu.R_imu_to_body" && !axes_by_attitudes_) {
    R_imu_to_body_ = FitAxes(*agreement.directions).R_turn * R_imu_to_body_;
  } else {
    return false;
  }
  return true;
}

void FlightDraft::SettleSensors() {
  // The clocks come first, since finding the axes needs course and gyros at the same time.
  for (int pass = 0; pass < 3; ++pass) {
    const Flight flight = ReadFlight(ParseFlightConfig(SensorsText(), folder_),
                                     {.imu = imu_.has_value(), .gnss = gnss_.has_value()});
    const DataAgreement agreement = FindDataAgreement(flight);
    bool changed = false;
    axes_notes_.clear();
    for (const DataHint& hint : DataHints(flight, agreement)) {
      const bool settled = SettleByHint(hint, agreement);
      changed = changed || settled;
      if (settled) found_.push_back(hint.text);
      if (!settled) axes_notes_.push_back(HintText(hint));
      if (settled && hint.key != "imu.R_imu_to_body") break;
    }
    axes_known_ =
        axes_by_attitudes_ || (agreement.directions && agreement.directions->course_b.has_value());
    if (flight.imu) {
      imu_summary_ = ImuSummary(*flight.imu);
      white_ = EstimateWhiteNoise(*flight.imu);
      white_.gyro_rad_per_sqrt_s *= kWhiteMargin;
      white_.accel_mps_per_sqrt_s *= kWhiteMargin;
    }
    if (flight.gnss) {
      gnss_summary_ = GnssSummary(*flight.gnss);
      utm_zone_ = FindUtmZone(flight.frame.origin());
    }
    if (!changed) break;
  }
}

void FlightDraft::SettleTrajectory() {
  // Coordinates come first: attitudes can be compared only if the place is right.
  for (int pass = 0; trajectory_ && pass < 3; ++pass) {
    trajectory_notes_.clear();
    bool changed = false;
    for (const DataHint& hint : HintsOnTrajectory()) {
      const bool settles = hint.key == "trajectory.columns" && !changed;
      if (settles) {
        UseTrajectoryColumns(ParseColumnNames(hint.value));
        found_.push_back(hint.text);
      } else {
        trajectory_notes_.push_back(HintText(hint));
      }
      changed = changed || settles;
    }
    if (!changed) return;
  }
}

std::vector<DataHint> FlightDraft::HintsOnTrajectory() const {
  try {
    return TrajectoryHints(ParseFlightConfig(ImuText() + GnssText() + TrajectoryText(), folder_));
  } catch (const InvalidInput&) {  // the zone of a grid is missing
    return {};
  }
}

void FlightDraft::UseTrajectoryColumns(const ColumnNames& columns) {
  const bool exchanged = LatitudeFirst(columns) != LatitudeFirst(trajectory_->columns);
  if (trajectory_->trajectory && exchanged) {
    // The attitude was found by the course of the exchanged coordinates.
    TrajectoryColumns& found = *trajectory_->trajectory;
    found.attitude = found.has_quaternion() ? TrajectoryColumns::Attitude::kQuaternionNed
                                            : TrajectoryColumns::Attitude::kRollPitchHeading;
  }
  if (trajectory_->trajectory) trajectory_->trajectory->body_is_flu = false;
  trajectory_->columns = columns;
}

std::optional<RoughPath> FlightDraft::FindPath() const {
  const bool flu = trajectory_ && trajectory_->trajectory && trajectory_->trajectory->body_is_flu;
  try {
    if (trajectory_ && !flu) {
      const Flight flight =
          ReadFlight(ParseFlightConfig(TrajectoryText(), folder_), {.trajectory = true});
      return RoughPath{flight.frame, flight.trajectory->ToMapPoses(flight.frame), false};
    }
    if (gnss_) {
      const Flight flight = ReadFlight(ParseFlightConfig(GnssText(), folder_), {.gnss = true});
      return PathFromGnss(*flight.gnss, flight.frame);
    }
  } catch (const InvalidInput&) {  // a note says so already, or the key of the system is missing
    return std::nullopt;
  }
  return std::nullopt;
}

void FlightDraft::SettleScanner() {
  if (pairs_.empty()) {
    const std::optional<RoughPath> path = FindPath();
    std::vector<std::string> guesses{"map", "ecef"};
    if (path) guesses.push_back("utm:" + FindUtmZone(path->frame.origin()));
    std::erase_if(strip_scanners_, [&](StripScanner& scanner) {
      return !SettleScannerByStrips(path ? &*path : nullptr, guesses, &scanner);
    });
    if (strip_scanners_.size() > 1 && strip_scanners_.front().name.empty()) {
      notes_.push_back("strips/ is not used: each of several scanners needs a folder strips_NAME/");
      strip_scanners_.erase(strip_scanners_.begin());
    }
    return;
  }
  LaserVectorSums sums;
  for (const FileContent& file : pairs_) {
    const TextTable table = ReadTextTable(file.file, {}, '#', 4000);
    if (HasBeams(table)) num_beams_ = std::max(num_beams_, CountBeams(file.file));
    for (std::size_t i = 0; i < table.rows(); ++i) {
      sums.Add(Eigen::Map<const Eigen::Vector3d>(table.row(i) + 2));
    }
  }
  axes_ = sums.Axes();
}

std::string FlightDraft::ImuText() const {
  if (!imu_) return {};
  const double gyro_deg_sqrt_h =
      std::max(white_.gyro_rad_per_sqrt_s * kDegPerRad / kSqrtHourPerSqrtS, 1e-4);
  const double accel_m_s_sqrt_h = std::max(white_.accel_mps_per_sqrt_s / kSqrtHourPerSqrtS, 1e-4);
  const BiasClass& biases = FindBiasClass(gyro_deg_sqrt_h);
  std::string text = fmt::format("\n# {}\nimu:\n  file: {}\n  format: {}\n", imu_summary_,
                                 QuoteYaml(Named(imu_->file)),
                                 imu_->imu_format == ImuFormat::kOdyn ? "odyn" : "increments");
  text += ColumnNamesText(*imu_);
  text +=
      "  sampling: mean                # assumed: rows are means; instantaneous: values at the "
      "tag\n";
  if (imu_->rates_in_deg)
    text += "  rate_unit: deg/s              # from the header or the size of the rates\n";
  if (imu_->forces_in_g)
    text += "  force_unit: g                 # from the header or the size of gravity\n";
  const bool rates = imu_->imu_format == ImuFormat::kOdyn;
  if (imu_->rate_unit > 0.0) {
    text += fmt::format("  rate_unit: {}   # {} of one unit of the file\n",
                        FormatDouble(imu_->rate_unit), rates ? "rad/s" : "rad");
  }
  if (imu_->force_unit > 0.0) {
    text += fmt::format("  force_unit: {}   # {} of one unit of the file\n",
                        FormatDouble(imu_->force_unit), rates ? "m/s^2" : "m/s");
  }
  text += fmt::format("  R_imu_to_body: {}   # data in axes {}: {}\n", MatrixText(R_imu_to_body_),
                      AxesName(R_imu_to_body_),
                      axes_by_attitudes_ ? "from the attitudes of the GNSS file"
                      : axes_known_      ? "from gravity and course"
                                         : "from gravity; forward is a guess");
  text += OffsetText(imu_offset_s_);
  text += fmt::format(
      "  # smooth, calibrate and gap estimate the noise from the flight. They start at the "
      "figures\n"
      "  # below. With a data sheet, state its figures and remove this line, or name a preset.\n"
      "  grade: unknown\n"
      "  # White noise: {}, times {:g}.\n"
      "  # The biases are assumed for {}.\n"
      "  gyro: {{white_deg_sqrt_h: {}, processes: [{}]}}\n"
      "  accel: {{white_m_s_sqrt_h: {}, processes: [{}]}}\n",
      white_.shaking ? "lowest level of the spectra; the platform SHAKES all the time"
                     : "power of the calmest tenth of the data",
      kWhiteMargin, biases.name, Short(gyro_deg_sqrt_h), biases.gyro, Short(accel_m_s_sqrt_h),
      biases.accel);
  return text;
}

std::string FlightDraft::GnssText() const {
  if (!gnss_) return {};
  const std::string format = GnssFormatWord(gnss_->gnss_format);
  std::string text = fmt::format("\n# {}\ngnss:\n  file: {}\n  format: {}\n", gnss_summary_,
                                 QuoteYaml(Named(gnss_->file)), format);
  text += ColumnNamesText(*gnss_);
  if (gnss_->only_changed) {
    text += "  rows: changed                 # the other rows repeat a position, or have none\n";
  }
  if (!gnss_->crs.empty()) {
    text += fmt::format("  crs: {:<25} # from the size of the coordinates\n", gnss_->crs);
  }
  text += OffsetText(gnss_offset_s_);
  text += "  lever_arm_m: [0, 0, 0]        # MISSING: antenna in body, forward right down, m\n";
  if (gnss_->has_sigma) {
    text += "  # The file states the sigmas of its positions.\n";
  } else if (gnss_->gnss_format == GnssFormat::kNmea) {
    text += NmeaSigmaText(nmea_qualities_);
  } else if (!gnss_->accuracy.empty()) {
    text +=
        fmt::format("  sigma_enu_m: [2, 2, 3]        # assumed: replace by the accuracy in {}\n",
                    gnss_->accuracy);
  } else if (gnss_->has_velocity) {
    text += "  sigma_enu_m: [2, 2, 3]        # assumed, a single receiver: the file states none\n";
  } else {
    text +=
        "  sigma_enu_m: [0.03, 0.03, 0.05]   # assumed, a differential solution: the file states "
        "none\n";
  }
  text += "  processes: auto               # time-correlated errors; [] for none\n";
  return text;
}

std::string FlightDraft::GeoreferencingText() const {
  if (strips_without_vectors_ == 0) return {};
  return fmt::format(
      "  # {} of strips/ have no laser vectors. These are computed from the points, with the "
      "boresight\n"
      "  # that the points were georeferenced with: roll, pitch, yaw; or `boresight`, which is "
      "boresight_deg.\n"
      "  # georeferenced_with: {{boresight_deg: [0, 0, 0]}}   # MISSING\n",
      strips_without_vectors_);
}

std::string FlightDraft::LidarText() const {
  if (pairs_.empty()) return ScannersText(strip_scanners_, GeoreferencingText());
  std::string files;
  for (const FileContent& file : pairs_) {
    files += (files.empty() ? "" : ", ") + QuoteYaml(Named(file.file));
  }
  return fmt::format("\nlidar:\n  p2p: [{}]\n", files) + MountingText(axes_, "  ") +
         "  sigma_p_m: 0.1                # assumed: per coordinate of a pair; or gsd_m\n" +
         BeamsText() + GeoreferencingText();
}

std::string FlightDraft::BeamsText() const {
  if (num_beams_ < 2) return {};
  const BeamConfig assumed;
  return fmt::format(
      "  # The pairs name the beams 0 to {} of a rotating scanner. Replace count by angles_deg,\n"
      "  # the vertical angles of the data sheet in this order: they check the numbers.\n"
      "  beams: {{count: {}, angle_sigma_deg: {:g}, range_offset_sigma_m: {:g}}}   # sigmas "
      "assumed\n",
      num_beams_ - 1, num_beams_, kDegPerRad * assumed.angle_sigma_rad, assumed.range_sigma_m);
}

std::string FlightDraft::TrajectoryText() const {
  if (!trajectory_) return {};
  std::string text =
      fmt::format("\ntrajectory:\n  file: {}\n", QuoteYaml(Named(trajectory_->file)));
  text += ColumnNamesText(*trajectory_);
  text += ColumnsText();
  if (smrmsg_) return text + fmt::format("  sigma_file: {}\n", QuoteYaml(Named(smrmsg_->file)));
  return text +
         "  sigma_xy_m: 0.03              # assumed, like the next three\n  sigma_z_m: 0.05\n"
         "  sigma_rp_deg: 0.003\n  sigma_y_deg: 0.005\n";
}

std::string FlightDraft::ColumnsText() const {
  if (!trajectory_->trajectory) return {};
  const TrajectoryColumns& columns = *trajectory_->trajectory;
  std::string text;
  if (IsInGrid(*trajectory_)) {
    text += utm_zone_.empty()
                ? "  crs: utm:ZONEn                # MISSING: the zone, e.g. utm:32n or utm:19s\n"
                : fmt::format("  crs: utm:{}                  # zone from the GNSS positions\n",
                              utm_zone_);
  } else if (columns.crs != "geographic") {
    text += fmt::format("  crs: {:<25} # from the size of the coordinates\n", columns.crs);
  }
  if (columns.attitude != TrajectoryColumns::Attitude::kQuaternionNed) {
    text += fmt::format("  attitude: {:<20} # from the course\n", AttitudeWord(columns.attitude));
  }
  return text;
}

std::string FlightDraft::SensorsText() const {
  std::string text =
      "# Written by dn init from the files of this folder. docs/reference/flight.yaml has all "
      "keys.\n"
      "# Values that do not follow from the data are marked MISSING, assumed or GUESS.\n"
      "body: FRD                       # axes of lever arms and mounting: forward, right, down\n";
  return text + ImuText() + GnssText() + LidarText();
}

std::string FlightDraft::UnmodelledText() const {
  std::vector<std::string> unknown;
  if (imu_ && gnss_) unknown.push_back(fmt::format("gnss_lever_arm: {}", kLeverArmSigmaM));
  if (LacksScannerLeverArm()) {
    unknown.push_back(fmt::format("lidar_lever_arm: {}", kLeverArmSigmaM));
  }
  if (unknown.empty()) return {};
  return fmt::format(
      "\n# The lever arms are MISSING: these are sigmas of what they may be, m. Remove each with "
      "the\n# surveyed lever arm.\nunmodelled: {{{}}}\n",
      fmt::join(unknown, ", "));
}

bool FlightDraft::LacksScannerLeverArm() const {
  return !pairs_.empty() || std::ranges::any_of(strip_scanners_, [](const StripScanner& scanner) {
    return !scanner.mounting || !scanner.mounting->lever_arm_b_m;
  });
}

std::string FlightDraft::Text() const {
  return SensorsText() + TrajectoryText() + UnmodelledText();
}

std::vector<std::string> FlightDraft::Missing() const {
  std::vector<std::string> missing = axes_notes_;
  missing.insert(missing.end(), trajectory_notes_.begin(), trajectory_notes_.end());
  missing.insert(missing.end(), strip_notes_.begin(), strip_notes_.end());
  if (!imu_) missing.emplace_back("no inertial data: smooth and calibrate --method dn need them");
  if (!gnss_) missing.emplace_back("no GNSS positions: smooth and calibrate --method dn need them");
  if (gnss_) missing.emplace_back("gnss.lever_arm_m: the antenna in body; 0 is assumed");
  if (gnss_ && !gnss_->has_sigma) missing.push_back(MissingSigma(*gnss_, nmea_qualities_));
  if (imu_) {
    missing.emplace_back(
        "imu.gyro and imu.accel: the data sheet; without it noise and biases are estimated "
        "(grade: unknown)");
  }
  if (imu_ && white_.shaking) {
    missing.emplace_back(
        "imu.gyro and imu.accel: white noise of the data sheet; the platform shakes all the time");
  }
  if (imu_ && !axes_known_) {
    missing.emplace_back("imu.R_imu_to_body: without a course the forward axis is unknown");
  }
  if (trajectory_ && IsInGrid(*trajectory_) && utm_zone_.empty()) {
    missing.emplace_back("trajectory.crs: the zone of the grid");
  }
  if (trajectory_ && trajectory_->trajectory && trajectory_->trajectory->crs == "map") {
    missing.emplace_back("frame.origin_deg_m: the origin of the trajectory's coordinates");
  }
  if (trajectory_ && trajectory_->trajectory && trajectory_->trajectory->body_is_flu) {
    missing.emplace_back(
        "the trajectory has body axes forward, left, up: write body: FLU, and give lever arms and "
        "mounting in these axes");
  }
  if (strips_without_vectors_ > 0) {
    missing.emplace_back(
        "lidar.georeferenced_with: the boresight that the strips without laser vectors were "
        "georeferenced with");
  }
  if (num_beams_ > 1) {
    missing.emplace_back("lidar.beams: the angles of the beams, and the sigmas of the data sheet");
  }
  if (!pairs_.empty()) {
    missing.emplace_back("lidar.lever_arm_m, lidar.R_sensor_to_body, lidar.sigma_p_m");
  } else if (!strip_scanners_.empty()) {
    AddMissingMountings(strip_scanners_, &missing);
  } else {
    missing.emplace_back("no pairs: calibrate needs them");
  }
  return missing;
}

}  // namespace dn::apps
