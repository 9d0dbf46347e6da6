#include <dn/axis_names.h>
#include <dn/diagnosis/beams_output.h>
#include <dn/diagnosis/result_files.h>
#include <dn/geo/local_frame.h>
#include <dn/report/wrapped.h>
#include <dn/study/study_output.h>
#include <fmt/format.h>

#include <cstddef>
#include <set>
#include <string>

namespace dn {
namespace {

std::string BoresightLines(const BoresightResult& boresight) {
  const Eigen::Vector3d sigma_deg = boresight.sigma_rad() * kDegPerRad;
  const Eigen::Matrix3d percent = 100.0 * boresight.correlation();
  std::string text = fmt::format("boresight {:>12} {:>26}\n", "sigma [deg]", "correlation [%]");
  for (int i = 0; i < 3; ++i) {
    text += fmt::format("  {:<7} {:>12.6f} {:>10.1f} {:>7.1f} {:>7.1f}\n", kRollPitchYaw[i],
                        sigma_deg[i], percent(i, 0), percent(i, 1), percent(i, 2));
  }
  text += fmt::format("condition number {:.1f}\n", boresight.condition_number);
  text += fmt::format(
      "correlation with the accelerometer bias max {:.1f} rms {:.1f}, with the gyro bias max "
      "{:.1f} rms {:.1f} [%]\n",
      100.0 * boresight.accel_bias.max_abs, 100.0 * boresight.accel_bias.rms,
      100.0 * boresight.gyro_bias.max_abs, 100.0 * boresight.gyro_bias.rms);
  return text;
}

std::string UnknownLines(const std::vector<StudyUnknown>& unknowns) {
  std::string text;
  for (const StudyUnknown& unknown : unknowns) {
    text += fmt::format("{} [{}], sigma", unknown.name, unknown.unit);
    for (const double sigma : unknown.sigma) text += fmt::format(" {:.3g}", sigma);
    text += "\n";
  }
  return text;
}

constexpr std::size_t kIndent = 10;

/// Returns cause and remedy of a weak direction.
std::string RemedyLines(const StudyResult& study, const StudyDirection& direction) {
  const std::string indent(kIndent, ' ');
  std::string remedy = RemedyWords(study, direction);
  if (const auto tried = direction.remedy()) {
    remedy += fmt::format(": {:.3g} {}", tried->sigma, direction.unit);
  }
  return "  cause   " + WrapText(CauseWords(study, direction), indent) + "  remedy  " +
         WrapText(remedy, indent);
}

std::string DirectionLines(const StudyDirection& direction) {
  std::string text = "weak      ";
  for (std::size_t i = 0; i < direction.unknowns.size(); ++i) {
    const auto& [name, weight] = direction.unknowns[i];
    text += fmt::format("{}{} ({:.2f})", i == 0 ? "" : ", ", name, weight);
  }
  return text + fmt::format(
                    "\n{}sigma of {} {:.3g} {} in the pure model, multiple correlation with the "
                    "others {:.2f}\n",
                    std::string(kIndent, ' '), direction.leading, direction.sigma, direction.unit,
                    direction.correlation);
}

/// Returns the weak directions. A cause with its remedy is told once.
std::string WeakLines(const StudyResult& study) {
  std::string text;
  std::set<std::string> told;
  for (const StudyDirection& direction : study.weak) {
    text += DirectionLines(direction);
    const std::string remedy = RemedyLines(study, direction);
    text += told.insert(remedy).second ? remedy : "  cause   as above, and the same remedy\n";
  }
  return text;
}

/// Returns the predicted sigmas of the scanners after the first, and of every two.
std::string ScannerLines(const ScannerMountings& mountings) {
  std::string text;
  const auto line = [&](const std::string& name, const Eigen::Vector3d& sigma_rad) {
    const Eigen::Vector3d deg = sigma_rad * kDegPerRad;
    text += fmt::format("boresight {}, sigma: roll {:.5f}, pitch {:.5f}, yaw {:.5f} deg\n", name,
                        deg.x(), deg.y(), deg.z());
  };
  for (std::size_t k = 1; k < mountings.scanners.size(); ++k) {
    line("of " + mountings.scanners[k].name, mountings.scanners[k].boresight.sigma_rad());
  }
  for (const RelativeMounting& relative : mountings.relative) {
    line(relative.from + " to " + relative.to, relative.sigma_rad());
  }
  return text;
}

}  // namespace

std::string StudySummary(const StudyResult& study) {
  std::string text = fmt::format(
      "{}: {} strips, {} pairs, {} inertial and {} GNSS epochs; {} nodes, {} unknowns\n",
      study.name, study.geometry.strips.size(), study.pairs, study.imu_epochs, study.gnss_epochs,
      study.nodes, study.parameters);
  if (!study.observable()) {
    text += "NOT OBSERVABLE: the numbers below are not accuracies\n";
    for (const std::string& reason : UnobservableWords(study)) {
      text += "  " + WrapText(reason, "    ");
    }
  }
  text += BoresightLines(study.boresight) + ContributionsSummary(study.boresight);
  text += ScannerLines(study.mountings) + UnknownLines(study.unknowns);
  text += BeamsSummary(study.beams, false);
  text += fmt::format(
      "trajectory on the strips, sigma: roll and pitch {:.5f} deg, yaw {:.5f} deg, position {:.4f} "
      "m\n",
      study.strips.roll_pitch_rad * kDegPerRad, study.strips.yaw_rad * kDegPerRad,
      study.strips.position_m);
  return text + WeakLines(study);
}

}  // namespace dn
