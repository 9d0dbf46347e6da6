#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <string_view>

namespace dn {

/// The source of the laser vectors of a strip, or of a file of pairs.
struct VectorOrigin {
  /// From the most to the least reliable.
  enum class Kind {
    kMeasured,  ///< the file contains them
    kRecorded,  ///< computed from coordinates, with the boresight that the strip records
    kDeclared,  ///< the same with the boresight that flight.yaml declares for the strips
    kAssumed,   ///< the same with the initial boresight: nothing says that the strips were made so
  };
  Kind kind = Kind::kMeasured;
  /// Boresight of the georeferencing, rotation vector about the body axes (FRD); computed vectors
  /// only.
  Eigen::Vector3d boresight_rad = Eigen::Vector3d::Zero();
};

/// "measured", "recorded", "declared" or "assumed".
const char* Word(VectorOrigin::Kind kind);

/// The less reliable of two; the first where they are equal.
const VectorOrigin& Weaker(const VectorOrigin& a, const VectorOrigin& b);

/// Comment line of a pair file, with its newline; empty for measured vectors:
///
///   # laser vectors computed with boresight 0.2, 0.03, 0.35 deg: assumed
std::string FormatOriginLine(const VectorOrigin& origin);

/// The origin that such a line states; nullopt for any other line. Throws InvalidInput for a line
/// that begins like one and is not.
std::optional<VectorOrigin> ParseOriginLine(std::string_view line);

}  // namespace dn
