#include <dn/diagnosis/result_files.h>
#include <dn/geo/local_frame.h>
#include <fmt/format.h>

#include <algorithm>

namespace dn {

std::string ContributionsSummary(const BoresightResult& boresight) {
  constexpr std::size_t kMostLines = 3;
  constexpr double kLeastShare = 0.1;  // of a sigma
  if (!boresight.as_modelled) return "";
  const Eigen::Vector3d pure_deg = boresight.as_modelled->sigma_rad() * kDegPerRad;
  std::string text = fmt::format(
      "sigmas without what the sensors leave unsaid [deg]: {:.6f} {:.6f} {:.6f}\n"
      "its largest parts in the sigmas, and what makes them smaller:\n",
      pure_deg.x(), pure_deg.y(), pure_deg.z());
  const std::vector<EffectContribution>& parts = boresight.contributions;
  for (std::size_t k = 0; k < std::min(kMostLines, parts.size()); ++k) {
    const Eigen::Vector3d share = parts[k].angle_sigma_rad.cwiseQuotient(boresight.sigma_rad());
    if (share.maxCoeff() < kLeastShare) break;
    const Eigen::Vector3d mdeg = parts[k].angle_sigma_rad * kDegPerRad * 1e3;
    text += fmt::format("  {:<22} {:>6.1f} {:>6.1f} {:>6.1f} mdeg; {}\n", parts[k].effect, mdeg.x(),
                        mdeg.y(), mdeg.z(), parts[k].remedy);
  }
  return text;
}

}  // namespace dn
