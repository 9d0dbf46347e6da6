#pragma once

#include <dn/error.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dn::files_internal {

/// The quantities of a control file.
enum class ControlColumn {
  kName,
  kEast,
  kNorth,
  kHeight,
  kLat,
  kLon,
  kSigmaEast,
  kSigmaNorth,
  kSigmaHeight,
  kSigma,  ///< of all three coordinates, or of a plane along its normal
  kTime,
  kUx,
  kUy,
  kUz,
  kNormalEast,
  kNormalNorth,
  kNormalUp,
  kExtent,
  kRole,
  kShape,
  kSkip,
};

/// The columns of a control file, in the order of the file.
class ControlColumns {
 public:
  /// Returns the columns that a line names. Returns nullopt if the line is not a header: one of its
  /// words names none of the columns. Throws InvalidInput for a header that names a column twice,
  /// or lacks the name or a coordinate. Also throws if it has only a part of a group such as t, ux,
  /// uy, uz.
  static std::optional<ControlColumns> FromHeader(const std::vector<std::string_view>& words,
                                                  const FileLocation& where);

  /// Returns the columns of a file without a header, by their number. geographic: the coordinates
  /// are latitude, longitude and height. Throws InvalidInput for another number of columns.
  static ControlColumns FromCount(std::size_t columns, bool geographic, const FileLocation& where);

  std::size_t size() const { return columns_.size(); }
  /// Returns the index of a column; nullopt if the file lacks it.
  std::optional<std::size_t> Find(ControlColumn column) const;
  bool geographic() const { return Find(ControlColumn::kLat).has_value(); }

 private:
  std::vector<ControlColumn> columns_;
};

/// Returns the names of all columns, for messages.
std::string ControlColumnNames();

}  // namespace dn::files_internal
