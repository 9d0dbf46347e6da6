#include "column_layout.h"

#include <dn/error.h>
#include <dn/geo/local_frame.h>

#include <algorithm>
#include <array>
#include <map>

namespace dn::geo_internal {
namespace {

constexpr double kPerMinute = 1.0 / 60.0, kPerSecond = 1.0 / 3600.0;

constexpr std::array<Addend, 14> kAddends{
    {{"undulation", "h", 1.0, false},
     {"nsec", "t", 1e-9, false},
     {"lat_min", "lat", kPerMinute, true},
     {"lat_sec", "lat", kPerSecond, true},
     {"lon_min", "lon", kPerMinute, true},
     {"lon_sec", "lon", kPerSecond, true},
     {"lat_ns", "lat", 1.0, false, "NS"},
     {"lon_ew", "lon", 1.0, false, "EW"},
     {"date_utc", "t", 1.0, false, "", DateOrder::kYearFirst},
     {"date_utc_dmy", "t", 1.0, false, "", DateOrder::kDayFirst},
     {"date_utc_mdy", "t", 1.0, false, "", DateOrder::kMonthFirst},
     {"date_gps", "t", 1.0, false, "", DateOrder::kYearFirst, true},
     {"date_gps_dmy", "t", 1.0, false, "", DateOrder::kDayFirst, true},
     {"date_gps_mdy", "t", 1.0, false, "", DateOrder::kMonthFirst, true}}};

/// Units at the end of a name: those of lengths, and angles as integers.
struct ColumnUnit {
  std::string_view ending;
  double factor;
  bool is_length;
};
constexpr std::array<ColumnUnit, 5> kColumnUnits{{{"_mm", 1e-3, true},
                                                  {"_cm", 1e-2, true},
                                                  {"_ft", 0.3048, true},
                                                  {"_usft", 1200.0 / 3937.0, true},
                                                  {"_1e7", 1e-7, false}}};

bool IsLength(std::string_view name) {
  constexpr std::array<std::string_view, 12> kLengths{"h",       "east",    "north",   "up",
                                                      "x",       "y",       "z",       "sigma_e",
                                                      "sigma_n", "sigma_u", "sigma_d", "sigma_en"};
  return std::find(kLengths.begin(), kLengths.end(), name) != kLengths.end();
}

/// Separates the unit at the end of a name. Returns its factor; 1 if there is none.
double TakeUnit(std::string_view* name) {
  for (const ColumnUnit& unit : kColumnUnits) {
    if (!name->ends_with(unit.ending)) continue;
    const std::string_view rest = name->substr(0, name->size() - unit.ending.size());
    const bool fits = unit.is_length ? IsLength(rest) : rest == "lat" || rest == "lon";
    if (!fits) continue;
    *name = rest;
    return unit.factor;
  }
  return 1.0;
}

const std::map<std::string, ColumnQuantity>& OtherNames() {
  constexpr ColumnForm kDdmm = ColumnForm::kDegreesMinutes, kVar = ColumnForm::kVariance,
                       kUtc = ColumnForm::kCalendarTime;
  static const std::map<std::string, ColumnQuantity> names{
      {"t_min", {"t", 60.0}},
      {"t_ms", {"t", 1e-3}},
      {"t_100us", {"t", 1e-4}},
      {"t_us", {"t", 1e-6}},
      {"t_ns", {"t", 1e-9}},
      {"east", {"lat"}},
      {"north", {"lon"}},
      {"up", {"h"}},
      {"x", {"lat"}},
      {"y", {"lon"}},
      {"z", {"h"}},
      {"yaw", {"heading"}},
      {"vd", {"vu", -1.0}},
      {"sigma_d", {"sigma_u"}},
      {"sigma_vd", {"sigma_vu"}},
      {"lat_rad", {"lat", kDegPerRad}},
      {"lon_rad", {"lon", kDegPerRad}},
      {"roll_rad", {"roll", kDegPerRad}},
      {"pitch_rad", {"pitch", kDegPerRad}},
      {"heading_rad", {"heading", kDegPerRad}},
      {"yaw_rad", {"heading", kDegPerRad}},
      {"lat_ddmm", {"lat", 1.0, kDdmm}},
      {"lon_ddmm", {"lon", 1.0, kDdmm}},
      {"var_e", {"sigma_e", 1.0, kVar}},
      {"var_n", {"sigma_n", 1.0, kVar}},
      {"var_u", {"sigma_u", 1.0, kVar}},
      {"t_utc", {"t", 1.0, kUtc}},
      {"time_of_day", {"t", 1.0, ColumnForm::kTimeOfDay}}};
  return names;
}

/// Splits the texts of a condition, as in "=A|B".
std::vector<std::string> SplitTexts(std::string_view condition) {
  std::vector<std::string> texts(1);
  for (const char c : condition.substr(1)) {
    if (c == '|') {
      texts.emplace_back();
    } else {
      texts.back() += c;
    }
  }
  return texts;
}

}  // namespace

ColumnQuantity ParseColumnName(std::string_view name) {
  ColumnQuantity column;
  if (name.starts_with('-')) {
    column.factor = -1.0;
    name.remove_prefix(1);
  }
  column.factor *= TakeUnit(&name);
  column.quantity = name;
  const auto other = OtherNames().find(column.quantity);
  if (other == OtherNames().end()) return column;
  column.quantity = other->second.quantity;
  column.factor *= other->second.factor;
  column.form = other->second.form;
  return column;
}

std::vector<std::string> GivenQuantities(const std::string& quantity) {
  if (quantity == "sigma_en") return {"sigma_e", "sigma_n"};
  return {quantity};
}

const Addend* FindAddend(std::string_view name) {
  const auto found = std::find_if(kAddends.begin(), kAddends.end(),
                                  [&](const Addend& addend) { return addend.name == name; });
  return found == kAddends.end() ? nullptr : &*found;
}

bool IsCondition(std::string_view name) { return name.starts_with('='); }

ColumnLayout::ColumnLayout(const ColumnNames& names, const std::vector<std::string>& quantities)
    : has_messages_(!names.empty() && IsCondition(names[0])) {
  for (const std::string& name : names) columns_.push_back(ParseColumnName(name));
  while (!columns_.empty() && columns_.back().quantity == "skip") columns_.pop_back();
  std::vector<std::string> all{"t"};
  all.insert(all.end(), quantities.begin(), quantities.end());
  for (const std::string& quantity : all) {
    const std::optional<std::size_t> place = Find(quantity);
    if (!place) throw InvalidInput("`columns` has no " + quantity + "; name its column");
    places_.push_back(*place);
  }
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const std::string& name = columns_[i].quantity;
    if (name == "week") week_ = i;
    if (IsCondition(name)) conditions_.push_back({i, SplitTexts(name)});
    const Addend* addend = FindAddend(name);
    if (addend == nullptr) continue;
    const auto column = std::find(all.begin(), all.end(), addend->quantity);
    if (column != all.end())
      added_.push_back({i, static_cast<std::size_t>(column - all.begin()), addend});
  }
}

bool ColumnLayout::Accepts(const std::vector<std::string_view>& fields) const {
  return std::all_of(conditions_.begin(), conditions_.end(), [&](const Condition& condition) {
    return condition.place < fields.size() &&
           std::find(condition.texts.begin(), condition.texts.end(), fields[condition.place]) !=
               condition.texts.end();
  });
}

std::optional<std::size_t> ColumnLayout::Find(std::string_view quantity) const {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    const std::vector<std::string> given = GivenQuantities(columns_[i].quantity);
    if (std::find(given.begin(), given.end(), quantity) != given.end()) return i;
  }
  return std::nullopt;
}

}  // namespace dn::geo_internal
