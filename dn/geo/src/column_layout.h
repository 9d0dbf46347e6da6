#pragma once

#include <dn/geo/gps_time.h>
#include <dn/geo/named_columns.h>

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dn::geo_internal {

/// How the text of a column gives a number: as a number, as a variance whose root is used, as
/// degrees and minutes (dddmm.mmmm), as a calendar time, or as a time of day.
enum class ColumnForm { kNumber, kVariance, kDegreesMinutes, kCalendarTime, kTimeOfDay };

/// A quantity of a column and the factor that converts the number to it.
struct ColumnQuantity {
  std::string quantity;
  double factor = 1.0;
  ColumnForm form = ColumnForm::kNumber;
};

/// Resolves sign, unit and other names of a quantity.
ColumnQuantity ParseColumnName(std::string_view name);

/// A column whose values are added to another quantity.
struct Addend {
  std::string_view name;
  std::string_view quantity;
  double factor;
  bool has_sign_of_column;  ///< minutes and seconds have the sign of the degrees
  /// Letters of the two hemispheres; the text of the column then gives the sign. Empty: a number.
  std::string_view hemispheres = {};
  /// The text of the column is a date, with the day and the month in this order.
  std::optional<DateOrder> date = {};
  bool is_gps = false;  ///< the date is in GPS time, not in UTC
};

/// Returns the addend with this name; nullptr if there is none.
const Addend* FindAddend(std::string_view name);

/// Returns the quantities that a column with this quantity gives; several for a sigma of east and
/// north.
std::vector<std::string> GivenQuantities(const std::string& quantity);

/// Returns whether a name is a condition, as in "=INSPVASA".
bool IsCondition(std::string_view name);

/// Places of the used columns in a line, in the order of the table: time, then quantities.
class ColumnLayout {
 public:
  /// The place of a column in a line, and the column of the table to which it is added.
  struct AddedPlace {
    std::size_t place, column;
    const Addend* addend;
  };

  /// Throws InvalidInput if a quantity has no column.
  ColumnLayout(const ColumnNames& names, const std::vector<std::string>& quantities);

  std::size_t least_fields() const { return columns_.size(); }
  const std::vector<std::size_t>& places() const { return places_; }
  const std::vector<AddedPlace>& added() const { return added_; }
  std::optional<std::size_t> week() const { return week_; }
  double factor(std::size_t place) const { return columns_[place].factor; }
  ColumnForm form(std::size_t place) const { return columns_[place].form; }
  /// Returns whether the lines begin with the name of their message.
  bool has_messages() const { return has_messages_; }
  /// Returns whether the fields of a line fulfil all conditions.
  bool Accepts(const std::vector<std::string_view>& fields) const;

 private:
  struct Condition {
    std::size_t place;
    std::vector<std::string> texts;  ///< one of these
  };

  std::optional<std::size_t> Find(std::string_view quantity) const;

  std::vector<ColumnQuantity> columns_;
  std::vector<std::size_t> places_;
  std::vector<AddedPlace> added_;
  std::vector<Condition> conditions_;
  std::optional<std::size_t> week_;
  bool has_messages_ = false;
};

}  // namespace dn::geo_internal
