#include <dn/lidar/beam.h>

#include "config_sections.h"

namespace dn {
namespace {

/// Reads a standard deviation that may be 0.
double ReadSigma(const YamlValue& value, double most) {
  const double sigma = ReadNotNegative(value);
  if (sigma > most) value.Fail("must be at most " + std::to_string(static_cast<int>(most)));
  return sigma;
}

}  // namespace

std::vector<double> ReadBeamAngles(const YamlValue& value) {
  std::vector<double> angles_rad;
  for (const YamlValue& item : value.List(kMostBeams)) {
    const double angle_deg = item.Number();
    if (!(angle_deg > -90.0 && angle_deg < 90.0)) item.Fail("must lie between -90 and 90 deg");
    angles_rad.push_back(RadFromDeg(angle_deg));
  }
  if (angles_rad.size() < 2) value.Fail("must have two beams or more");
  return angles_rad;
}

void ReadBeamSigmas(const YamlValue& section, double* angle_rad, double* range_m) {
  constexpr double kMostAngleDeg = 5.0, kMostRangeM = 1.0;
  if (const YamlValue angle = section["angle_sigma_deg"]) {
    *angle_rad = RadFromDeg(ReadSigma(angle, kMostAngleDeg));
  }
  if (const YamlValue range = section["range_offset_sigma_m"]) {
    *range_m = ReadSigma(range, kMostRangeM);
  }
}

namespace files_internal {

BeamConfig ReadBeams(const YamlValue& section) {
  section.ExpectMap({"count", "angles_deg", "angle_sigma_deg", "range_offset_sigma_m"});
  BeamConfig beams;
  const YamlValue count = section["count"], angles = section["angles_deg"];
  if (angles) beams.angles_rad = ReadBeamAngles(angles);
  if (!count && !angles) {
    section["angles_deg"].Fail(
        "is required: the angle of each beam from the plane across scan_axis, in the order of the "
        "beam numbers; or `count`, the number of beams, if the angles are unknown");
  }
  beams.count = count ? static_cast<std::size_t>(count.Integer(2)) : beams.angles_rad.size();
  if (beams.count > kMostBeams) count.Fail("must be at most " + std::to_string(kMostBeams));
  if (angles && beams.count != beams.angles_rad.size()) {
    count.Fail("differs from the number of angles_deg, " + std::to_string(beams.angles_rad.size()));
  }
  ReadBeamSigmas(section, &beams.angle_sigma_rad, &beams.range_sigma_m);
  return beams;
}

}  // namespace files_internal
}  // namespace dn
