#include "message_log.h"

#include <dn/geo/text_fields.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <map>
#include <string>

#include "imu_counts.h"
#include "picked_columns.h"

namespace dn::files_internal {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kRowsLookedAt = 4000;
constexpr const char* kSolution = "=INS_SOLUTION_GOOD|INS_SOLUTION_FREE|INS_ALIGNMENT_COMPLETE";
// Measured positions: neither propagated ones nor those with inertial data.
constexpr const char* kPositionTypes =
    "=NARROW_INT|NARROW_FLOAT|WIDE_INT|L1_INT|L1_FLOAT|PPP|PPP_CONVERGING|PPP_BASIC|"
    "PPP_BASIC_CONVERGING|OMNISTAR|OMNISTAR_HP|OMNISTAR_XP|PSRDIFF|WAAS|SINGLE";

/// A message and its fields after the header, from the manual of the receiver.
struct Message {
  std::string name, short_name;  ///< with the long header and with the short one
  FileKind kind;
  bool time_in_header;  ///< the fields have no time
  ColumnNames fields;
};

// Messages that come first are preferred.
const std::vector<Message>& KnownMessages() {
  static const ColumnNames position{
      "=SOL_COMPUTED", kPositionTypes, "lat",     "lon",     "h",
      "undulation",    "skip",         "sigma_n", "sigma_e", "sigma_u"};
  static const std::vector<Message> messages{
      {"RAWIMUXA",
       "RAWIMUSXA",
       FileKind::kImu,
       false,
       {"skip", "skip", "week", "t", "skip", "fz", "-fy", "fx", "wz", "-wy", "wx"}},
      {"RAWIMUA",
       "RAWIMUSA",
       FileKind::kImu,
       false,
       {"week", "t", "skip", "fz", "-fy", "fx", "wz", "-wy", "wx"}},
      {"BESTGNSSPOSA", "", FileKind::kGnss, true, position},
      {"BESTGPSPOSA", "", FileKind::kGnss, true, position},
      {"BESTPOSA", "", FileKind::kGnss, true, position},
      {"INSPVAA",
       "INSPVASA",
       FileKind::kTrajectory,
       false,
       {"week", "t", "lat", "lon", "h", "skip", "skip", "skip", "roll", "pitch", "heading",
        kSolution}},
      {"INSPVAXA",
       "",
       FileKind::kTrajectory,
       true,
       {kSolution, "skip", "lat", "lon", "h", "undulation", "skip", "skip", "skip", "roll", "pitch",
        "heading"}}};
  return messages;
}

/// Returns the name of the message of a line, such as RAWIMUSA; empty if the line has none.
std::string_view MessageName(std::string_view line) {
  if (!line.starts_with('#') && !line.starts_with('%')) return {};
  const std::size_t comma = line.find(','), end = line.find(';');
  if (comma == line.npos || end == line.npos || end < comma) return {};
  return line.substr(1, comma - 1);
}

/// A message that is not read, and the one to log instead.
struct OtherMessage {
  std::string_view beginning;
  const char* advice;
};
constexpr std::array<OtherMessage, 7> kOtherMessages{
    {{"CORRIMU", "has corrected increments; log RAWIMUX"},
     {"IMURATECORRIMU", "has corrected increments; log RAWIMUX"},
     {"BESTXYZ", "has geocentric positions; log BESTGNSSPOS"},
     {"BESTVEL", "has velocities only; log BESTGNSSPOS"},
     {"INSATT", "has the attitude only; log INSPVAX"},
     {"INSPOS", "has the position only; log INSPVAX"},
     {"INSSTDEV", "has standard deviations only; log INSPVAX"}}};

/// Names the messages of a log that are not read.
std::string OtherMessagesText(const std::map<std::string, std::string_view>& lines) {
  std::string text;
  for (const auto& [name, line] : lines) {
    for (const OtherMessage& other : kOtherMessages) {
      if (!name.starts_with(other.beginning)) continue;
      text += (text.empty() ? "" : ", ") + name + " is not read: it " + other.advice;
    }
  }
  return text;
}

/// Returns the first line of each message.
std::map<std::string, std::string_view> FirstLines(std::string_view text) {
  std::map<std::string, std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    const std::string_view line = text.substr(0, end);
    const std::string_view name = MessageName(line);
    if (!name.empty() && end < text.size()) lines.emplace(name, line);
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return lines;
}

/// Returns the names of all fields of the lines. A line that begins with # has the long header.
ColumnNames Columns(const Message& message, const std::string& name, std::string_view line) {
  ColumnNames columns{"=" + name};
  if (!line.starts_with('#')) {
    columns.insert(columns.end(), 2, "skip");
  } else if (!message.time_in_header) {
    columns.insert(columns.end(), 9, "skip");
  } else {
    columns.insert(columns.end(), {"skip", "skip", "skip", "skip", "week", "t"});
    columns.insert(columns.end(), 3, "skip");
  }
  columns.insert(columns.end(), message.fields.begin(), message.fields.end());
  return columns;
}

/// Returns the mean force, counts/s; 0 if there are no rows.
double MeanForce(const TextTable& table) {
  double sum = 0.0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    sum += Eigen::Map<const Eigen::Vector3d>(table.row(i) + 4).norm();
  }
  const double step_s = MedianTimeStep(table);
  return step_s > 0.0 ? sum / static_cast<double>(table.rows()) / step_s : 0.0;
}

void DescribeImu(const std::string& name, FileContent* content) {
  content->imu_format = ImuFormat::kIncrements;
  const ImuCounts* counts = FindImuCounts(
      MeanForce(ReadNamedColumns(content->file, content->columns, ImuQuantities(), kRowsLookedAt)));
  if (counts == nullptr) {
    content->kind = FileKind::kUnknown;
    content->why = "the counts of " + name +
                   " do not give gravity for a known sensor; set imu.columns: " +
                   FormatColumnNames(content->columns) +
                   ", and in imu.rate_unit and imu.force_unit the rad and m/s of one count";
    return;
  }
  content->rate_unit = counts->angle_rad;
  content->force_unit = counts->velocity_mps;
  content->why = "the counts of " + name + " have the size of " + counts->sensors +
                 " according to gravity; compare imu.rate_unit with the manual";
}

/// Returns whether a position is one of inertial data. BESTPOS has these where there are any.
bool HasInertialPosition(std::string_view beginning) {
  return beginning.find(";SOL_COMPUTED,INS_") != beginning.npos;
}

FileContent Describe(const fs::path& file, const Message& message, const std::string& name,
                     std::string_view line, std::string_view beginning) {
  FileContent content;
  content.file = file;
  content.kind = message.kind;
  content.columns = Columns(message, name, line);
  if (message.kind == FileKind::kImu) DescribeImu(name, &content);
  if (message.kind == FileKind::kGnss) content.has_sigma = true;
  if (message.kind == FileKind::kTrajectory) {
    content.trajectory.emplace();
    content.trajectory->attitude = TrajectoryColumns::Attitude::kRollPitchHeading;
    content.why = name + " is the receiver's solution in real time; smooth computes a better one";
  }
  if (name == "BESTPOSA" && HasInertialPosition(beginning)) {
    content.kind = FileKind::kUnknown;
    content.why = "BESTPOS contains the solution with inertial data; log BESTGNSSPOS";
  }
  return content;
}

}  // namespace

std::vector<FileContent> FindMessages(const fs::path& file, std::string_view beginning) {
  const std::map<std::string, std::string_view> lines = FirstLines(beginning);
  std::vector<FileContent> contents;
  for (const Message& message : KnownMessages()) {
    const bool known = std::any_of(contents.begin(), contents.end(), [&](const FileContent& each) {
      return each.kind == message.kind;
    });
    if (known) continue;
    for (const std::string& name : {message.name, message.short_name}) {
      const auto line = lines.find(name);
      if (line == lines.end()) continue;
      contents.push_back(Describe(file, message, name, line->second, beginning));
      break;
    }
  }
  const std::string others = OtherMessagesText(lines);
  if (others.empty()) return contents;
  if (contents.empty()) contents.emplace_back().file = file;
  std::string& why = contents.front().why;
  why += (why.empty() ? "" : "; ") + others;
  return contents;
}

}  // namespace dn::files_internal
