#include "control_file.h"

#include <dn/geo/read_file.h>
#include <dn/geo/text_fields.h>
#include <dn/geo/text_table.h>
#include <dn/names.h>

#include <array>
#include <utility>

#include "control_columns.h"
#include "lower_case.h"

namespace dn::files_internal {
namespace {

using C = ControlColumn;
using Fields = std::vector<std::string_view>;

constexpr std::size_t kLongestName = 60;
constexpr double kLeastSigma = 1e-6;  // a micrometre, or the like in feet
constexpr double kShortestVectorM = 1e-3, kLongestVectorM = 5e4;

/// A comment begins at a # that begins a word.
std::string_view WithoutComment(std::string_view line) {
  for (std::size_t i = 0; i < line.size(); ++i) {
    if (line[i] != '#') continue;
    if (i == 0 || line[i - 1] == ' ' || line[i - 1] == '\t') return line.substr(0, i);
  }
  return line;
}

bool IsBlank(std::string_view field) { return field.empty() || field == "-"; }

/// Reads one row with known columns.
class RowReader {
 public:
  RowReader(const ControlColumns& columns, const Fields& fields, FileLocation where)
      : columns_(columns), fields_(fields), where_(std::move(where)) {}

  ControlRow Read() const {
    ControlRow row;
    row.where = where_;
    row.name = ReadPointName();
    row.geographic = columns_.geographic();
    row.coordinates =
        Eigen::Vector3d(Number(row.geographic ? C::kLat : C::kEast),
                        Number(row.geographic ? C::kLon : C::kNorth), Number(C::kHeight));
    row.normal = Triple({C::kNormalEast, C::kNormalNorth, C::kNormalUp});
    if (row.normal && !(row.normal->norm() > 0.0)) Fail("the normal has no length");
    ReadSigmas(&row);
    ReadReturn(&row);
    if (const auto at = Given(C::kRole)) row.is_check = ReadRole(fields_[*at]);
    if (const auto at = Given(C::kShape)) row.is_corner = ReadIsCorner(fields_[*at]);
    if (row.is_corner && row.normal) {
      Fail(
          "a row with a normal is a plane, and cannot have the shape corner; leave one of them "
          "out");
    }
    return row;
  }

 private:
  [[noreturn]] void Fail(const std::string& what) const { throw InvalidInput(what, where_); }

  /// Returns the index of a column that is not blank in this row.
  std::optional<std::size_t> Given(C column) const {
    const auto at = columns_.Find(column);
    return at && !IsBlank(fields_[*at]) ? at : std::nullopt;
  }

  std::string ReadPointName() const {
    std::string name(fields_[*columns_.Find(C::kName)]);
    if (name.empty() || name.size() > kLongestName || WithoutControls(name) != name) {
      Fail("the name of a point must have 1 to 60 printable characters");
    }
    return name;
  }

  double Number(C column) const { return ParseNumber(fields_[*columns_.Find(column)], where_); }

  std::optional<Eigen::Vector3d> Triple(const std::array<C, 3>& group) const {
    Eigen::Vector3d values;
    int given = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      if (!Given(group[k])) continue;
      values[static_cast<Eigen::Index>(k)] = Number(group[k]);
      ++given;
    }
    if (given == 0) return std::nullopt;
    if (given < 3) Fail("of three values that belong together, some are blank; give all or none");
    return values;
  }

  double Sigma(double sigma) const {
    if (sigma < kLeastSigma) {
      Fail("sigma is " + FormatDouble(sigma) +
           ", must be positive: state the accuracy of the survey, such as 0.015 m");
    }
    return sigma;
  }

  void ReadSigmas(ControlRow* row) const {
    row->sigma = Triple({C::kSigmaEast, C::kSigmaNorth, C::kSigmaHeight});
    if (row->sigma) {
      for (const double one : *row->sigma) Sigma(one);
    }
    if (Given(C::kSigma)) {
      const double sigma = Sigma(Number(C::kSigma));
      if (row->normal) row->normal_sigma = sigma;
      if (!row->normal && !row->sigma) row->sigma = Eigen::Vector3d::Constant(sigma);
    }
    if (!Given(C::kExtent)) return;
    row->extent = Number(C::kExtent);
    if (*row->extent < 0.0) Fail("the extent of a plane must not be negative");
  }

  void ReadReturn(ControlRow* row) const {
    const auto vector = Triple({C::kUx, C::kUy, C::kUz});
    if (vector.has_value() != Given(C::kTime).has_value()) {
      Fail("a laser vector (ux, uy, uz) and its epoch (t) belong together; give all four or none");
    }
    if (!vector) return;
    const double length_m = vector->norm();
    if (!(length_m >= kShortestVectorM && length_m <= kLongestVectorM)) {
      Fail("the laser vector has a length of " + FormatDouble(length_m) +
           " m, must be between 0.001 and 50000 m");
    }
    row->t_s = Number(C::kTime);
    row->u_s = *vector;
  }

  bool ReadRole(std::string_view word) const {
    const std::string role = LowerCase(word);
    if (role == "check") return true;
    if (role == "observation" || role == "control") return false;
    Fail("the role is '" + WithoutControls(std::string(word.substr(0, kLongestName))) +
         "', must be observation or check");
  }

  bool ReadIsCorner(std::string_view word) const {
    const std::string shape = LowerCase(word);
    if (shape == "corner") return true;
    if (shape == "surface") return false;
    Fail("the shape is '" + WithoutControls(std::string(word.substr(0, kLongestName))) +
         "', must be surface or corner");
  }

  const ControlColumns& columns_;
  const Fields& fields_;
  FileLocation where_;
};

/// Reads a control file line by line.
class FileRows {
 public:
  FileRows(std::filesystem::path file, bool geographic)
      : file_(std::move(file)), geographic_(geographic) {}

  std::vector<ControlRow> Read() {
    LineReader lines(file_);
    for (std::string_view line; lines.Next(&line);) Take(line, {file_.string(), lines.line(), 0});
    if (rows_.empty()) {
      throw InvalidInput(
          "the control file has no points; put one per row: name, east, north, "
          "height, or remove the file",
          {file_.string()});
    }
    return std::move(rows_);
  }

 private:
  void Take(std::string_view line, const FileLocation& where) {
    const std::size_t begin = line.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos) return;
    if (line[begin] == '#') {
      if (rows_.empty() && !columns_) TakeHeader(SplitFields(line.substr(begin + 1)), where);
      return;
    }
    const Fields fields = SplitFields(WithoutComment(line));
    if (fields.empty()) return;
    if (rows_.empty() && !columns_) {
      TakeHeader(fields, where);
      if (columns_) return;
      ExpectNoHeader(fields, where);
      columns_ = ControlColumns::FromCount(fields.size(), geographic_, where);
    }
    AddRow(fields, where);
  }

  void TakeHeader(const Fields& words, const FileLocation& where) {
    columns_ = ControlColumns::FromHeader(words, where);
  }

  /// Throws InvalidInput for a first row of words with one that names none of the columns.
  static void ExpectNoHeader(const Fields& fields, const FileLocation& where) {
    for (const std::string_view field : fields) {
      if (FieldNumber(field)) return;
    }
    if (fields.size() < 4) return;
    throw InvalidInput("the header has a word that names no column; the columns are " +
                           ControlColumnNames() + "; name the others skip",
                       where);
  }

  void AddRow(Fields fields, const FileLocation& where) {
    // SplitFields does not count an empty field at the end of the line.
    if (fields.size() + 1 == columns_->size()) fields.emplace_back();
    if (fields.size() != columns_->size()) {
      throw InvalidInput("row has " + std::to_string(fields.size()) +
                             " columns, but the header or the rows before it have " +
                             std::to_string(columns_->size()) +
                             "; write - for a value that is missing",
                         where);
    }
    rows_.push_back(RowReader(*columns_, fields, where).Read());
  }

  std::filesystem::path file_;
  bool geographic_;
  std::optional<ControlColumns> columns_;
  std::vector<ControlRow> rows_;
};

}  // namespace

std::vector<ControlRow> ReadControlRows(const std::filesystem::path& file, bool geographic) {
  return FileRows(file, geographic).Read();
}

}  // namespace dn::files_internal
