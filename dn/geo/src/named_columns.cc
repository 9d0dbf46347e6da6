#include <dn/geo/local_frame.h>
#include <dn/geo/named_columns.h>
#include <dn/geo/text_fields.h>

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <string_view>

namespace dn {
namespace {

/// A quantity of a column and the factor that converts the column to it.
struct Column {
  std::string quantity;
  double factor = 1.0;
};

const std::map<std::string, Column>& OtherNames() {
  static const std::map<std::string, Column> names{{"t_ms", {"t", 1e-3}},
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
                                                   {"yaw_rad", {"heading", kDegPerRad}}};
  return names;
}

Column ParseName(std::string_view name) {
  Column column;
  if (name.starts_with('-')) {
    column.factor = -1.0;
    name.remove_prefix(1);
  }
  column.quantity = name;
  const auto other = OtherNames().find(column.quantity);
  if (other == OtherNames().end()) return column;
  column.quantity = other->second.quantity;
  column.factor *= other->second.factor;
  return column;
}

std::vector<Column> ParseNames(const ColumnNames& names) {
  std::vector<Column> columns;
  for (const std::string& name : names) columns.push_back(ParseName(name));
  return columns;
}

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

/// Places of the used columns in a line, in the order of the table.
class Layout {
 public:
  Layout(const ColumnNames& names, const std::vector<std::string>& quantities)
      : columns_(ParseNames(names)) {
    while (!columns_.empty() && columns_.back().quantity == "skip") columns_.pop_back();
    places_.push_back(Place("t"));
    for (const std::string& quantity : quantities) places_.push_back(Place(quantity));
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].quantity == "week") week_ = i;
    }
  }

  std::size_t least_fields() const { return columns_.size(); }
  std::size_t time_place() const { return places_.front(); }
  const std::vector<std::size_t>& places() const { return places_; }
  std::optional<std::size_t> week() const { return week_; }
  double factor(std::size_t place) const { return columns_[place].factor; }

 private:
  std::size_t Place(const std::string& quantity) const {
    for (std::size_t i = 0; i < columns_.size(); ++i) {
      if (columns_[i].quantity == quantity) return i;
    }
    throw InvalidInput("`columns` has no " + quantity + "; name its column");
  }

  std::vector<Column> columns_;
  std::vector<std::size_t> places_;
  std::optional<std::size_t> week_;
};

/// Appends the used values of lines to a table.
class NamedRows {
 public:
  NamedRows(const Layout& layout, TextTable* table) : layout_(layout), table_(*table) {}

  void Take(std::string_view line, long number) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos || line[begin] == '#' || line[begin] == '%') return;
    const std::vector<std::string_view> fields = SplitFields(line);
    const std::size_t time = layout_.time_place();
    const bool has_time = time < fields.size() && FieldNumber(fields[time]);
    if (table_.lines.empty() && !has_time) return;  // a line of the header
    if (fields.size() < layout_.least_fields()) {
      throw InvalidInput("row has " + std::to_string(fields.size()) +
                             " columns, but `columns` names " +
                             std::to_string(layout_.least_fields()),
                         {table_.file.string(), number, 0});
    }
    const auto value = [&](std::size_t place) {
      return layout_.factor(place) *
             ParseNumber(fields[place],
                         {table_.file.string(), number,
                          static_cast<long>(fields[place].data() - line.data()) + 1});
    };
    for (const std::size_t place : layout_.places()) table_.values.push_back(value(place));
    table_.lines.push_back(number);
    if (layout_.week()) AddWeek(value(*layout_.week()));
  }

 private:
  void AddWeek(double week) {
    if (table_.lines.size() == 1) first_week_ = week;
    table_.values[table_.values.size() - table_.columns] += kWeekS * (week - first_week_);
  }

  const Layout& layout_;
  TextTable& table_;
  double first_week_ = 0.0;
};

}  // namespace

bool HasColumn(const ColumnNames& names, const std::string& quantity) {
  return std::any_of(names.begin(), names.end(),
                     [&](const std::string& name) { return ParseName(name).quantity == quantity; });
}

std::string FormatColumnNames(const ColumnNames& names) { return "[" + Listed(names) + "]"; }

void CheckColumnNames(const ColumnNames& names, const std::vector<std::string>& quantities) {
  std::set<std::string> seen;
  for (const std::string& name : names) {
    const Column column = ParseName(name);
    const std::string& quantity = column.quantity;
    if (quantity == "skip") continue;
    const bool known =
        quantity == "t" || quantity == "week" ||
        std::find(quantities.begin(), quantities.end(), quantity) != quantities.end();
    if (!known) {
      throw InvalidInput("'" + name +
                         "' is not a column; the columns are t (t_ms, t_us, t_ns), week, " +
                         Listed(quantities) + ", skip");
    }
    if (!seen.insert(quantity).second) throw InvalidInput("'" + name + "' is named twice");
  }
  if (!seen.contains("t")) throw InvalidInput("no column is the time, t");
}

TextTable ReadNamedColumns(const std::filesystem::path& file, const ColumnNames& names,
                           const std::vector<std::string>& quantities, std::size_t max_rows) {
  const Layout layout(names, quantities);
  TextTable table;
  table.file = file;
  table.columns = 1 + quantities.size();
  NamedRows rows(layout, &table);
  LineReader lines(file);
  for (std::string_view line; table.rows() < max_rows && lines.Next(&line);) {
    rows.Take(line, lines.line());
  }
  if (table.rows() == 0) throw InvalidInput("file has no rows of numbers", {file.string(), 0, 0});
  return table;
}

}  // namespace dn
