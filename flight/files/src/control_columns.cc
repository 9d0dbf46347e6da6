#include "control_columns.h"

#include <algorithm>
#include <initializer_list>
#include <utility>

#include "lower_case.h"

namespace dn::files_internal {
namespace {

using C = ControlColumn;

struct ControlNames {
  C column;
  std::vector<std::string> names;  ///< the first one is shown in messages
};

const std::vector<ControlNames>& AllControlNames() {
  static const std::vector<ControlNames> all{
      {C::kName, {"name", "id", "point", "pt"}},
      {C::kEast, {"east", "e", "easting"}},
      {C::kNorth, {"north", "n", "northing"}},
      {C::kHeight, {"height", "h", "u", "up", "z", "elevation"}},
      {C::kLat, {"lat", "latitude"}},
      {C::kLon, {"lon", "long", "longitude"}},
      {C::kSigmaEast, {"sigma_e", "sigma_east", "se"}},
      {C::kSigmaNorth, {"sigma_n", "sigma_north", "sn"}},
      {C::kSigmaHeight, {"sigma_h", "sigma_height", "sigma_u", "sh"}},
      {C::kSigma, {"sigma"}},
      {C::kTime, {"t", "time", "epoch"}},
      {C::kUx, {"ux"}},
      {C::kUy, {"uy"}},
      {C::kUz, {"uz"}},
      {C::kNormalEast, {"normal_e", "normal_east"}},
      {C::kNormalNorth, {"normal_n", "normal_north"}},
      {C::kNormalUp, {"normal_u", "normal_up"}},
      {C::kExtent, {"extent", "radius"}},
      {C::kRole, {"role"}},
      {C::kShape, {"shape"}},
      {C::kSkip, {"skip", "code", "remark"}},
  };
  return all;
}

/// Returns a word of a header in lower case, without its unit: "East [m]" is "east".
std::string WithoutUnit(std::string_view word) {
  std::string text = LowerCase(word.substr(0, word.find_first_of("[(")));
  for (const std::string_view unit : {"_m", "_deg", "_s"}) {
    if (text.size() > unit.size() && text.ends_with(unit)) text.resize(text.size() - unit.size());
  }
  text.erase(text.find_last_not_of(' ') + 1);
  return text;
}

std::optional<C> ColumnNamed(std::string_view word) {
  const std::string name = WithoutUnit(word);
  for (const ControlNames& one : AllControlNames()) {
    if (std::find(one.names.begin(), one.names.end(), name) != one.names.end()) return one.column;
  }
  return std::nullopt;
}

std::string FirstName(C column) {
  const auto at = std::find_if(AllControlNames().begin(), AllControlNames().end(),
                               [&](const ControlNames& one) { return one.column == column; });
  return at->names.front();
}

std::string List(std::initializer_list<C> columns) {
  std::string text;
  for (const C column : columns) text += (text.empty() ? "" : ", ") + FirstName(column);
  return text;
}

/// Throws InvalidInput if some of the columns are there, but not all.
void ExpectWhole(const ControlColumns& columns, std::initializer_list<C> group,
                 const FileLocation& where) {
  const auto found = std::count_if(group.begin(), group.end(),
                                   [&](C column) { return columns.Find(column).has_value(); });
  if (found == 0 || found == static_cast<std::ptrdiff_t>(group.size())) return;
  throw InvalidInput("the header names only some of the columns " + List(group) + "; name all",
                     where);
}

void ExpectColumn(const ControlColumns& columns, C column, const FileLocation& where) {
  if (columns.Find(column)) return;
  throw InvalidInput("the header names no column '" + FirstName(column) +
                         "'; a point needs name, " +
                         "east, north, height, or name, lat, lon, height",
                     where);
}

}  // namespace

std::optional<ControlColumns> ControlColumns::FromHeader(const std::vector<std::string_view>& words,
                                                         const FileLocation& where) {
  ControlColumns columns;
  for (const std::string_view word : words) {
    const std::optional<C> column = ColumnNamed(word);
    if (!column) return std::nullopt;
    if (*column != C::kSkip && columns.Find(*column)) {
      throw InvalidInput("the header names the column '" + FirstName(*column) + "' twice", where);
    }
    columns.columns_.push_back(*column);
  }
  if (words.size() < 4) return std::nullopt;
  ExpectColumn(columns, C::kName, where);
  ExpectColumn(columns, C::kHeight, where);
  ExpectWhole(columns, {C::kLat, C::kLon}, where);
  if (!columns.geographic()) {
    ExpectColumn(columns, C::kEast, where);
    ExpectColumn(columns, C::kNorth, where);
  } else if (columns.Find(C::kEast) || columns.Find(C::kNorth)) {
    throw InvalidInput("the header names both lat, lon and east, north; keep one of the two",
                       where);
  }
  ExpectWhole(columns, {C::kSigmaEast, C::kSigmaNorth, C::kSigmaHeight}, where);
  ExpectWhole(columns, {C::kTime, C::kUx, C::kUy, C::kUz}, where);
  ExpectWhole(columns, {C::kNormalEast, C::kNormalNorth, C::kNormalUp}, where);
  return columns;
}

ControlColumns ControlColumns::FromCount(std::size_t count, bool geographic,
                                         const FileLocation& where) {
  ControlColumns columns;
  std::vector<C>& list = columns.columns_;
  list = {C::kName, C::kEast, C::kNorth, C::kHeight};
  if (geographic) std::copy_n(std::begin({C::kLat, C::kLon}), 2, list.begin() + 1);
  const auto add = [&](std::initializer_list<C> more) {
    list.insert(list.end(), more.begin(), more.end());
  };
  const bool plane = count == 8 || count == 9;
  if (plane) add({C::kNormalEast, C::kNormalNorth, C::kNormalUp, C::kSigma, C::kExtent});
  if (!plane) add({C::kSigmaEast, C::kSigmaNorth, C::kSigmaHeight});
  if (count == 11) add({C::kTime, C::kUx, C::kUy, C::kUz});
  if (count != 4 && count != 7 && !plane && count != 11) {
    throw InvalidInput(
        "row has " + std::to_string(count) +
            " columns; without a header it must have 4 (name and coordinates), 7 (and three "
            "sigmas), 11 (and t, ux, uy, uz), or for a plane 8 (name, coordinates, normal, sigma) "
            "or 9 (and extent); else begin the file with a header of " +
            ControlColumnNames(),
        where);
  }
  list.resize(count);
  return columns;
}

std::optional<std::size_t> ControlColumns::Find(ControlColumn column) const {
  const auto at = std::find(columns_.begin(), columns_.end(), column);
  if (at == columns_.end()) return std::nullopt;
  return static_cast<std::size_t>(at - columns_.begin());
}

std::string ControlColumnNames() {
  std::string text;
  for (const ControlNames& one : AllControlNames())
    text += (text.empty() ? "" : ", ") + one.names.front();
  return text;
}

}  // namespace dn::files_internal
