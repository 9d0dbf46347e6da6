#include "trajectory_fit.h"

#include <dn/geo/local_frame.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "gnss_path.h"
#include "picked_columns.h"
#include "trajectory_content.h"

namespace dn::files_internal {
namespace {

constexpr StepRange kTrajectorySteps{1e-4, 60.0, 0.05};
using NamedColumns = std::vector<NamedColumn>;

/// An order of the columns of an attitude, with the sign of the vector part of a quaternion.
struct AttitudeOrder {
  std::array<const char*, 4> names;
  const char* text;
};
constexpr std::array<AttitudeOrder, 4> kAttitudeOrders{
    {{{"qw", "qx", "qy", "qz"}, ""},
     {{"qx", "qy", "qz", "qw"}, "the quaternions have w last"},
     {{"qw", "-qx", "-qy", "-qz"}, "the quaternions are of the inverse rotation"},
     {{"-qx", "-qy", "-qz", "qw"}, "the quaternions have w last and are of the inverse rotation"}}};

std::string WithoutSignAndUnit(const std::string& name) {
  const std::size_t begin = name.starts_with('-') ? 1 : 0;
  return name.substr(begin, name.rfind("_rad") - begin);
}

double Factor(const std::string& name) {
  return (name.starts_with('-') ? -1.0 : 1.0) * (name.ends_with("_rad") ? kDegPerRad : 1.0);
}

/// Returns the columns in the order of the documented format, whatever their order in the file.
NamedColumns InUsualOrder(const NamedColumns& columns) {
  NamedColumns usual;
  for (const char* name : {"lat", "lon", "h", "qw", "qx", "qy", "qz", "roll", "pitch", "heading"}) {
    for (const NamedColumn& column : columns) {
      if (WithoutSignAndUnit(column.name) == name) usual.push_back(column);
    }
  }
  return usual;
}

/// Returns the rows in deg and with the signs of the names.
TextTable RowsInDegrees(const TextSample& sample, const TimeColumn& time,
                        const NamedColumns& columns) {
  TextTable table = PickRows(sample, time, columns);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    const double factor = Factor(columns[c].name);
    if (factor == 1.0) continue;
    for (std::size_t i = 0; i < table.rows(); ++i)
      table.values[i * table.columns + 1 + c] *= factor;
  }
  return table;
}

/// Columns in the usual order with what is unusual about them.
struct TrajectoryChoice {
  NamedColumns columns;
  std::string text;
  NamedColumns added = {};  ///< minutes and seconds
};

TrajectoryChoice WithAnglesInRadians(TrajectoryChoice choice) {
  for (NamedColumn& column : choice.columns) {
    const bool angle = column.name == "roll" || column.name == "pitch" || column.name == "heading";
    if (angle) column.name += "_rad";
  }
  choice.text += choice.text.empty() ? "" : ", and ";
  choice.text += "the angles are in rad";
  return choice;
}

/// Returns the named columns of one of several sets; empty if no set is complete.
NamedColumns FindSet(const std::vector<ColumnMeaning>& meanings,
                     const std::vector<std::vector<std::string>>& sets) {
  for (const std::vector<std::string>& names : sets) {
    NamedColumns columns;
    for (const std::string& name : names) {
      std::optional<NamedColumn> column = FindColumn(meanings, name);
      if (!column) break;
      if (meanings[column->at].unit.starts_with("rad")) column->name += "_rad";
      columns.push_back(*column);
    }
    if (columns.size() == names.size()) return columns;
  }
  return {};
}

/// Returns the columns with known names, with angles in the unit of their name, else in deg or rad.
std::vector<TrajectoryChoice> NamedTrajectoryChoices(const TextSample& sample) {
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  NamedColumns columns = FindSet(
      meanings,
      {{"lat", "lon", "h"}, {"east", "north", "h"}, {"east", "north", "up"}, {"x", "y", "z"}});
  const NamedColumns attitude =
      FindSet(meanings, {{"qw", "qx", "qy", "qz"}, {"roll", "pitch", "heading"}});
  if (columns.empty() || attitude.empty()) return {};
  columns.insert(columns.end(), attitude.begin(), attitude.end());
  std::vector<TrajectoryChoice> choices{{columns, "", FindMinutes(meanings)}};
  const bool angles = attitude.front().name == "roll";
  if (angles && meanings[attitude.front().at].unit.empty()) {
    choices.push_back(WithAnglesInRadians(choices.front()));
  }
  return choices;
}

/// Returns the usual columns first, then other orders.
std::vector<TrajectoryChoice> TrajectoryChoicesByCount(const TextSample& sample,
                                                       const TimeColumn& time) {
  const std::size_t first = std::max(time.at, time.week.value_or(0)) + 1;
  const std::size_t count = sample.table.columns - std::min(sample.table.columns, first);
  std::vector<TrajectoryChoice> choices;
  if (count != 6 && count != 7) return choices;
  for (const bool longitude_first : {false, true}) {
    const NamedColumns position{{longitude_first ? "lon" : "lat", first},
                                {longitude_first ? "lat" : "lon", first + 1},
                                {"h", first + 2}};
    const std::string text = longitude_first ? "the longitude comes before the latitude" : "";
    if (count == 6) {
      NamedColumns columns = position;
      for (const char* name : {"roll", "pitch", "heading"}) {
        columns.push_back({name, columns.back().at + 1});
      }
      choices.push_back({InUsualOrder(columns), text});
      choices.push_back(WithAnglesInRadians(choices.back()));
      continue;
    }
    for (const AttitudeOrder& order : kAttitudeOrders) {
      NamedColumns columns = position;
      for (const char* name : order.names) columns.push_back({name, columns.back().at + 1});
      const std::string both = text.empty() || *order.text == 0 ? "" : ", and ";
      choices.push_back({InUsualOrder(columns), text + both + order.text});
    }
  }
  return choices;
}

bool IsPlainTrajectory(const TextSample& sample, const TimeColumn& time,
                       const TrajectoryChoice& choice) {
  if (sample.needs_names || time.week || time.at != 0 || time.name != "t") return false;
  for (std::size_t i = 0; i < choice.columns.size(); ++i) {
    if (choice.columns[i].at != i + 1 || Factor(choice.columns[i].name) != 1.0) return false;
  }
  return sample.table.columns == choice.columns.size() + 1;
}

/// Returns the first choice whose attitude follows the course; the first of all if none does.
const TrajectoryChoice& BestTrajectoryChoice(const TextSample& sample, const TimeColumn& time,
                                             const std::vector<TrajectoryChoice>& choices) {
  for (const TrajectoryChoice& choice : choices) {
    const TextTable table = RowsInDegrees(sample, time, choice.columns);
    if (table.rows() == 0) continue;
    if (CourseAgreement(table).value_or(0.0) >= kLeastCourseAgreement) return choice;
  }
  return choices.front();
}

/// Returns whether the three angles of all rows are the same, as qualities and counts are.
bool AreConstantAngles(const TextTable& table) {
  for (std::size_t i = 1; i < table.rows(); ++i) {
    if (!std::equal(table.row(i) + 4, table.row(i) + 7, table.row(0) + 4)) return false;
  }
  return table.rows() > 1;
}

/// Says what a trajectory lacks.
std::string NoPose(const TextSample& sample, const std::vector<ColumnMeaning>& meanings) {
  const auto sea = FindColumn(meanings, "h_msl");
  if (!sea || !FindColumn(meanings, "heading")) return "no position and attitude";
  return "'" + sample.names[sea->at] +
         "' is above the sea, and no column is a height above the ellipsoid: export this one "
         "(H-Ell)";
}

}  // namespace

ContentFit FitTrajectory(const TextSample& sample) {
  FileContent content;
  content.kind = FileKind::kTrajectory;
  FitTests tests(4.0);
  const std::optional<TimeColumn> time = FindTime(sample, kTrajectorySteps);
  if (!tests.Expect(time.has_value(), "no time that increases")) return tests.Result(content);
  std::vector<TrajectoryChoice> choices = NamedTrajectoryChoices(sample);
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  const bool inertial = FindColumn(meanings, "wx") && FindColumn(meanings, "fx");
  if (choices.empty() && !inertial && !FindColumn(meanings, "lat")) {
    choices = TrajectoryChoicesByCount(sample, *time);
  }
  if (!tests.Expect(!choices.empty(), NoPose(sample, meanings))) return tests.Result(content);
  const TrajectoryChoice& choice = BestTrajectoryChoice(sample, *time, choices);
  const TextTable table = RowsInDegrees(sample, *time, choice.columns);
  if (!tests.Expect(AreNumbers(table, sample), "the columns contain text"))
    return tests.Result(content);
  content.trajectory = FindTrajectoryColumns(table);
  const bool by_count = NamedTrajectoryChoices(sample).empty();
  const bool fixed = by_count && table.columns == 7 && AreConstantAngles(table);
  tests.Expect(content.trajectory.has_value() && !fixed,
               "no unit quaternion, and no heading that follows the course");
  content.time_offset_s = FindTimeOffset(table.row(0)[0]);
  content.why = choice.text;
  if (!IsPlainTrajectory(sample, *time, choice)) {
    NamedColumns all = choice.columns;
    all.insert(all.end(), choice.added.begin(), choice.added.end());
    content.columns = FormatNames(*time, all);
  }
  return tests.Result(std::move(content));
}

NamedColumns FindAngles(const TextSample& sample) {
  const std::vector<ColumnMeaning> meanings = FindMeanings(sample);
  NamedColumns angles = FindSet(meanings, {{"roll", "pitch", "heading"}});
  if (angles.empty() || !meanings[angles.front().at].unit.empty()) return angles;
  const auto exceeds_turn = [&](const NamedColumn& angle) {
    return LargestValue(sample.table, angle.at) > 2.0 * std::numbers::pi;
  };
  if (std::ranges::any_of(angles, exceeds_turn)) return angles;
  return WithAnglesInRadians({angles, ""}).columns;
}

}  // namespace dn::files_internal
