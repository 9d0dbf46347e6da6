#include "config_sections.h"

namespace dn::internal {

GnssConfig ReadGnssSection(const YamlValue& section, bool body_is_flu) {
  section.ExpectMap(
      {"file", "format", "lever_arm_m", "sigma_enu_m", "sigma_scale", "use_velocity", "robust"});
  GnssConfig gnss;
  if (section["file"]) gnss.file = section["file"].Text();
  if (section["format"]) gnss.format = section["format"].Choice(GnssFormatWords());
  if (section["lever_arm_m"]) {
    const Eigen::Vector3d lever_arm_m = section["lever_arm_m"].Vector3();
    gnss.lever_arm_b_m = body_is_flu ? FlipBody(lever_arm_m) : lever_arm_m;
  }
  if (section["sigma_enu_m"]) gnss.sigma_enu_m = section["sigma_enu_m"].PositiveVector3();
  if (section["sigma_scale"]) gnss.sigma_scale = section["sigma_scale"].Positive();
  if (section["use_velocity"]) {
    static const Words<std::optional<bool>> words{
        {"auto", std::nullopt}, {"true", true}, {"false", false}};
    gnss.use_velocity = section["use_velocity"].Choice(words);
  }
  if (section["robust"]) gnss.robust = section["robust"].Choice(RobustWords());
  return gnss;
}

TrajectoryConfig ReadTrajectorySection(const YamlValue& section) {
  section.ExpectMap(
      {"file", "sigma_xy_m", "sigma_z_m", "sigma_rp_deg", "sigma_y_deg", "sigma_file"});
  TrajectoryConfig trajectory;
  if (section["file"]) trajectory.file = section["file"].Text();
  if (section["sigma_file"]) trajectory.sigma_file = section["sigma_file"].Text();
  if (section["sigma_xy_m"]) trajectory.sigma_xy_m = section["sigma_xy_m"].Positive();
  if (section["sigma_z_m"]) trajectory.sigma_z_m = section["sigma_z_m"].Positive();
  if (section["sigma_rp_deg"]) {
    trajectory.sigma_rp_rad = RadFromDeg(section["sigma_rp_deg"].Positive());
  }
  if (section["sigma_y_deg"]) {
    trajectory.sigma_y_rad = RadFromDeg(section["sigma_y_deg"].Positive());
  }
  return trajectory;
}

}  // namespace dn::internal
