#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/geo/text_table.h>
#include <dn/lidar/vector_origin.h>

#include <array>

namespace dn {
namespace {

using Kind = VectorOrigin::Kind;

constexpr std::string_view kBegin = "# laser vectors computed with boresight ";
constexpr std::string_view kUnit = " deg: ";
constexpr std::array<Kind, 3> kComputed{Kind::kRecorded, Kind::kDeclared, Kind::kAssumed};

[[noreturn]] void Fail() {
  throw InvalidInput("the line '" + std::string(kBegin) +
                     "r, p, y deg: WORD' must have three angles and recorded, declared or assumed; "
                     "match the strips again");
}

Kind ParseKind(std::string_view word) {
  for (const Kind kind : kComputed) {
    if (word == Word(kind)) return kind;
  }
  Fail();
}

double TakeAngle(std::string_view* text) {
  const std::size_t end = text->find(", ");
  const double deg = ParseNumber(text->substr(0, end), {});
  text->remove_prefix(end == std::string_view::npos ? text->size() : end + 2);
  return deg;
}

}  // namespace

const char* Word(Kind kind) {
  switch (kind) {
    case Kind::kMeasured:
      break;
    case Kind::kRecorded:
      return "recorded";
    case Kind::kDeclared:
      return "declared";
    case Kind::kAssumed:
      return "assumed";
  }
  return "measured";
}

const VectorOrigin& Weaker(const VectorOrigin& a, const VectorOrigin& b) {
  return b.kind > a.kind ? b : a;
}

std::string FormatOriginLine(const VectorOrigin& origin) {
  if (origin.kind == Kind::kMeasured) return {};
  const Eigen::Vector3d deg = origin.boresight_rad * kDegPerRad;
  return std::string(kBegin) + FormatDouble(deg.x()) + ", " + FormatDouble(deg.y()) + ", " +
         FormatDouble(deg.z()) + std::string(kUnit) + Word(origin.kind) + "\n";
}

std::optional<VectorOrigin> ParseOriginLine(std::string_view line) {
  if (!line.starts_with(kBegin)) return std::nullopt;
  line.remove_prefix(kBegin.size());
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
  const std::size_t unit = line.find(kUnit);
  if (unit == std::string_view::npos) Fail();
  VectorOrigin origin;
  origin.kind = ParseKind(line.substr(unit + kUnit.size()));
  std::string_view angles = line.substr(0, unit);
  for (double& angle_rad : origin.boresight_rad) angle_rad = TakeAngle(&angles) * kRadPerDeg;
  if (!angles.empty()) Fail();
  return origin;
}

}  // namespace dn
