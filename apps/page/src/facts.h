#pragma once

#include <dn/report/document.h>
#include <dn/report/json.h>

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace dn::internal {

/// How many elements of lists and objects the files of one folder may still bring onto a page: its
/// size must not follow from a damaged file.
using RowsLeft = std::shared_ptr<std::size_t>;

/// A place in a JSON file, whether it is there or not: what is absent, or of another kind, is NaN,
/// empty, without elements. Functions that list elements throw InvalidInput where `rows_left` or
/// the longest list of texts is exceeded.
class Facts {
 public:
  Facts() = default;
  Facts(std::string file, Json json, RowsLeft rows_left);

  Facts operator[](const std::string& key) const;
  Facts operator[](std::size_t index) const;
  /// Elements of a list, values of an object.
  std::vector<Facts> elements() const;
  /// Of an object.
  std::vector<std::string> keys() const;

  explicit operator bool() const { return json_ != nullptr && !json_->is_null(); }
  double number() const;
  bool flag() const;
  std::string text() const;
  /// The points of a list of pairs of numbers.
  Curve points(const std::string& label) const;
  /// The texts of a list.
  std::vector<std::string> texts() const;
  /// Three numbers; NaN where there are not three.
  Eigen::Vector3d vector3() const;
  Eigen::Matrix3d matrix3() const;

  /// Cells that carry value and source.
  Cell Significant(int digits = 4, double scale = 1.0) const;
  Cell Decimals(int digits, double scale = 1.0) const;
  Cell Count() const { return Decimals(0); }

 private:
  Facts At(const Json* json, const std::string& key) const;
  void Take(std::size_t rows) const;
  Cell CellOf(Number::Style style, int digits, double scale) const;

  std::string source_;  // file#/pointer
  std::shared_ptr<const Json> root_;
  RowsLeft rows_left_;
  const Json* json_ = nullptr;
};

/// What a chart leaves out.
inline const double kNone = std::numeric_limits<double>::quiet_NaN();

/// A cell of a text.
Cell Text(std::string text, Tone tone = Tone::kPlain);

}  // namespace dn::internal
