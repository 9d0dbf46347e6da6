#pragma once

#include <dn/eigen_alignment.h>

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

namespace dn {

/// The source of the laser vectors of a strip, or of a file of pairs.
struct VectorOrigin {
  /// Kinds, from the most to the least reliable.
  enum class Kind {
    kMeasured,  ///< the file contains them
    kRecorded,  ///< computed from coordinates, with the boresight that the strip records
    kDeclared,  ///< computed with the boresight that flight.yaml declares for the strips
    kAssumed,   ///< computed with the initial boresight, because no other is known
  };
  Kind kind = Kind::kMeasured;
  /// Boresight of the georeferencing, rotation vector about the body axes (FRD); computed vectors
  /// only.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
};

/// Returns "measured", "recorded", "declared" or "assumed".
const char* Word(VectorOrigin::Kind kind);

/// Returns the less reliable of two origins, or the first if they are equally reliable.
const VectorOrigin& Weaker(const VectorOrigin& a, const VectorOrigin& b);

/// Returns the comment line of a pair file, with its newline; empty for measured vectors:
///
///   # laser vectors computed with boresight 0.2, 0.03, 0.35 deg: assumed
std::string FormatOriginLine(const VectorOrigin& origin);

/// Returns the origin that such a line states; nullopt for any other line. Throws InvalidInput for
/// a line that begins like such a line but is invalid.
std::optional<VectorOrigin> ParseOriginLine(std::string_view line);

}  // namespace dn
