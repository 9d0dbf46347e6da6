#pragma once

#include <dn/report/document.h>
#include <dn/report/json.h>

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace dn::page_internal {

/// Number of elements of lists and objects that the files of one folder may still add to a page. It
/// bounds the size of the page of a damaged file.
using RowsLeft = std::shared_ptr<std::size_t>;

/// A place in a JSON file, which may be absent. An absent value, or one of another type, is NaN, an
/// empty text or a list without elements. Functions that list elements throw InvalidInput beyond
/// `rows_left` or the longest list of texts.
class Facts {
 public:
  Facts() = default;
  Facts(std::string file, Json json, RowsLeft rows_left);

  Facts operator[](const std::string& key) const;
  Facts operator[](std::size_t index) const;
  /// Returns the elements of a list, or the values of an object.
  std::vector<Facts> elements() const;
  /// Returns the keys of an object.
  std::vector<std::string> keys() const;

  explicit operator bool() const { return json_ != nullptr && !json_->is_null(); }
  double number() const;
  bool flag() const;
  std::string text() const;
  /// Returns the points of a list of pairs of numbers.
  Curve points(const std::string& label) const;
  /// Returns the texts of a list.
  std::vector<std::string> texts() const;
  /// Returns three numbers, with NaN for each that is missing.
  Eigen::Vector3d vector3() const;
  Eigen::Matrix3d matrix3() const;

  /// Returns a cell with value and source.
  Cell Significant(int digits = 4, double scale = 1.0) const;
  Cell Decimals(int digits, double scale = 1.0) const;
  Cell Count() const { return Decimals(0); }

 private:
  Facts At(const Json* json, const std::string& key) const;
  void Take(std::size_t rows) const;
  Cell MakeCell(Number::Style style, int digits, double scale) const;

  std::string source_;  // file#/pointer
  std::shared_ptr<const Json> root_;
  RowsLeft rows_left_;
  const Json* json_ = nullptr;
};

/// Value that charts leave out.
inline const double kNone = std::numeric_limits<double>::quiet_NaN();

/// Returns a cell with a text.
Cell Text(std::string text, Tone tone = Tone::kPlain);

}  // namespace dn::page_internal
