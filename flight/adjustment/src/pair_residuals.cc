#include <dn/adjustment/pair_residuals.h>
#include <dn/adjustment/swath_separation.h>
#include <dn/files/scan_angle.h>
#include <dn/files/scanners.h>
#include <dn/files/strip_at.h>
#include <dn/geo/text_table.h>

#include <algorithm>
#include <utility>

namespace dn {
namespace {

using Eigen::Vector3d;

ResidualEnd DescribeEnd(const Flight& flight, const LidarConfig& scanner, double t_s,
                        const Vector3d& u_s, const MapPose& pose) {
  return {t_s, ScanAngle(scanner, u_s), u_s.norm(),
          RollPitchHeading(ToNavPoint(pose, flight.frame).q_nb).z()};
}

PairResidual Describe(const Flight& flight, const std::vector<StripInterval>& strips,
                      const LidarPair& pair, const MapPose& pose_i, const MapPose& pose_j) {
  const LidarConfig& i = ScannerAt(flight.config, static_cast<std::size_t>(pair.scanner_i));
  const LidarConfig& j = ScannerAt(flight.config, static_cast<std::size_t>(pair.scanner_j));
  const Vector3d p_i = Georeference(pose_i, i.mounting, pair.u_i_s);
  const Vector3d p_j = Georeference(pose_j, j.mounting, pair.u_j_s);
  PairResidual residual;
  residual.i = DescribeEnd(flight, i, pair.t_i_s, pair.u_i_s, pose_i);
  residual.j = DescribeEnd(flight, j, pair.t_j_s, pair.u_j_s, pose_j);
  residual.strips = StripPairName(strips, pair.t_i_s, pair.t_j_s);
  residual.ground_m = 0.5 * (p_i + p_j);
  residual.before_enu_m = p_i - p_j;
  return residual;
}

MapPose EndPose(const GaussHelmertEnd& end) {
  MapPose pose;
  pose.t_s = end.t_s;
  pose.q_mb = end.q_mb;
  pose.p_mb = end.p_mb;
  return pose;
}

/// Sums over the pairs of one strip pair.
struct Sums {
  std::string strips;
  long pairs = 0;
  Vector3d sum[2] = {Vector3d::Zero(), Vector3d::Zero()};  // before, after
  Vector3d squares[2] = {Vector3d::Zero(), Vector3d::Zero()};
  double lengths[2] = {0.0, 0.0};
  SwathSeparation separation[2];

  void Add(const PairResidual& residual) {
    ++pairs;
    const Vector3d* differences[] = {&residual.before_enu_m, &residual.after_enu_m};
    for (int k = 0; k < 2; ++k) {
      sum[k] += *differences[k];
      squares[k] += differences[k]->cwiseAbs2();
      lengths[k] += differences[k]->norm();
      separation[k].Add(differences[k]->z());
    }
  }

  Json ToJson(int k) const {
    const auto n = static_cast<double>(pairs);
    return {{"mean_enu_m", dn::ToJson(sum[k] / n)},
            {"rms_enu_m", dn::ToJson((squares[k] / n).cwiseSqrt())},
            {"mean_m", lengths[k] / n},
            {"separation", separation[k].ToJson()}};
  }
};

/// Returns the index of a name in a list; appends the name if it is missing.
std::size_t FindOrAppend(const std::string& name, std::vector<std::string>* names) {
  const auto at = std::find(names->begin(), names->end(), name);
  const auto place = static_cast<std::size_t>(at - names->begin());
  if (at == names->end()) names->push_back(name);
  return place;
}

}  // namespace

std::vector<PairResidual> PairResiduals(const FlightNetwork& network,
                                        const PoseInterpolator& poses) {
  const Flight& flight = network.flight();
  const std::vector<StripInterval> strips = FindStrips(flight);
  std::vector<PairResidual> residuals;
  for (std::size_t k = 0; k < network.pairs().edges().size(); ++k) {
    const PairEdge& edge = network.pairs().edges()[k];
    if (!network.net().factor(edge.id).active) continue;
    const LidarPair& pair = edge.pair;
    residuals.push_back(
        Describe(flight, strips, pair, poses.Nearest(pair.t_i_s), poses.Nearest(pair.t_j_s)));
    residuals.back().after_enu_m = network.pairs().Difference(k);
  }
  return residuals;
}

std::vector<PairResidual> PairResiduals(const Flight& flight,
                                        const GaussHelmertCalibration& calibration) {
  const std::vector<StripInterval> strips = FindStrips(flight);
  const GaussHelmertResult& adjustment = calibration.adjustment;
  std::vector<PairResidual> residuals;
  for (std::size_t k = 0; k < adjustment.weights.size(); ++k) {
    if (adjustment.weights[k] == 0.0) continue;
    const GaussHelmertPair& pair = calibration.problem.pairs[k];
    residuals.push_back(
        Describe(flight, strips, flight.pairs->pairs[k], EndPose(pair.i), EndPose(pair.j)));
    residuals.back().after_enu_m =
        LinearisePair(pair, calibration.problem.lever_arm_b_m, calibration.options.model,
                      adjustment.boresight_rad, PairCorrection::Zero())
            .w;
  }
  return residuals;
}

std::string FormatPairResiduals(const std::vector<PairResidual>& residuals) {
  std::string text =
      "# t_i, t_j [s], pair of strips, ground E, N [m], before E, N, U [m], after E, N, U [m], "
      "scan "
      "angle i, j [deg], range i, j [m], heading i, j [deg]\n";
  std::vector<std::string> names;
  for (const PairResidual& r : residuals) {
    const auto strips = static_cast<double>(FindOrAppend(r.strips, &names) + 1);
    text += FormatDouble(r.i.t_s);
    for (const double value :
         {r.j.t_s, strips, r.ground_m.x(), r.ground_m.y(), r.before_enu_m.x(), r.before_enu_m.y(),
          r.before_enu_m.z(), r.after_enu_m.x(), r.after_enu_m.y(), r.after_enu_m.z(),
          r.i.scan_angle_rad * kDegPerRad, r.j.scan_angle_rad * kDegPerRad, r.i.range_m,
          r.j.range_m, r.i.heading_rad * kDegPerRad, r.j.heading_rad * kDegPerRad}) {
      text += ", " + FormatDouble(value);
    }
    text += '\n';
  }
  return text;
}

Json StripPairsJson(const std::vector<PairResidual>& residuals) {
  std::vector<std::string> names;
  std::vector<Sums> sums;
  Sums all;
  all.strips = "all";
  for (const PairResidual& residual : residuals) {
    const std::size_t place = FindOrAppend(residual.strips, &names);
    sums.resize(names.size());
    sums[place].strips = residual.strips;
    sums[place].Add(residual);
    all.Add(residual);
  }
  Json list = Json::array();
  if (residuals.empty()) return list;
  sums.push_back(std::move(all));
  for (const Sums& sum : sums) {
    list.push_back({{"strips", sum.strips},
                    {"pairs", sum.pairs},
                    {"before", sum.ToJson(0)},
                    {"after", sum.ToJson(1)}});
  }
  return list;
}

}  // namespace dn
