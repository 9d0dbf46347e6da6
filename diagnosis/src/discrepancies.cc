#include "discrepancies.h"

#include <dn/builder/gnss_multipath.h>
#include <dn/builder/node_grid.h>
#include <dn/factors/gnss_antenna.h>
#include <dn/factors/lidar_effect.h>
#include <dn/files/scan_angle.h>
#include <dn/files/scanners.h>
#include <dn/geo/nearest_pose.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <utility>

namespace dn::diagnosis_internal {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Typical sizes of unmodelled discrepancies.
constexpr double kBoresightRad = 5e-5;
constexpr double kGnssM = 0.02;
constexpr double kLaserM = 0.02;

constexpr int kScanAngleBumps = 7;
constexpr double kNarrowestRad = 1e-3;
constexpr double kSettlingOfStrips[] = {1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0};

/// Corrects a vector of a reading by the weighted sum of the values, which are three-vectors.
template <class Effect, class Reading, auto kVector, auto kJacobian, int kSign>
class WeightedSum final : public Effect {
 public:
  using Weights = std::function<void(const Reading&, VectorXd*)>;
  WeightedSum(int count, Weights weights) : count_(count), weights_(std::move(weights)) {}
  int components() const override { return 3 * count_; }
  void Correct(const Eigen::Ref<const VectorXd>& value, Eigen::Index column,
               Reading* reading) const override {
    VectorXd w = VectorXd::Zero(count_);
    weights_(*reading, &w);
    for (int k = 0; k < count_; ++k) {
      if (w[k] == 0.0) continue;
      const double weight = kSign * w[k];
      reading->*kVector += weight * value.segment<3>(3 * k);
      (reading->*kJacobian).template middleCols<3>(column + 3 * k) =
          weight * Eigen::Matrix3d::Identity();
    }
  }

 private:
  int count_;
  Weights weights_;
};

using LaserOffset =
    WeightedSum<LidarEffect, LidarReading, &LidarReading::u_s, &LidarReading::J_u, -1>;
using BoresightTurn =
    WeightedSum<LidarEffect, LidarReading, &LidarReading::turn_b_rad, &LidarReading::J_turn, 1>;
using GnssShift =
    WeightedSum<GnssEffect, GnssReading, &GnssReading::shift_m, &GnssReading::J_shift, 1>;

template <class Sum>
Hypothesis MakeSum(const std::string& name, int count, double typical,
                   typename Sum::Weights weights) {
  return MakeDiscrepancy(name, std::make_shared<const Sum>(count, std::move(weights)), 3 * count,
                         typical);
}

/// Returns a discrepancy whose weights depend on the time of the reading.
template <class Sum, class Weights>
Hypothesis MakeSumByTime(const std::string& name, int count, double typical,
                         const Weights& weights) {
  return MakeSum<Sum>(name, count, typical, [weights](const auto& reading, VectorXd* w) {
    weights(reading.tag_s - reading.delay_s, w);
  });
}

/// `ends` returns the two laser vectors of a pair.
template <class Pair, class Ends>
ScanAngleRange FindRange(const LidarConfig& lidar, const std::vector<Pair>& pairs,
                         const Ends& ends) {
  ScanAngleRange range;
  for (const Pair& pair : pairs) {
    for (const Vector3d& u_s : ends(pair)) {
      const double angle_rad = ScanAngle(lidar, u_s);
      range.low_rad = std::min(range.low_rad, angle_rad);
      range.high_rad = std::max(range.high_rad, angle_rad);
    }
  }
  range.high_rad = std::max(range.high_rad, range.low_rad + kNarrowestRad);
  return range;
}

}  // namespace

ScanAngleRange FindScanAngleRange(const LidarConfig& lidar, const std::vector<PairEnds>& pairs) {
  return FindRange(lidar, pairs, [](const PairEnds& pair) {
    return std::array{pair.i.u_s, pair.j.u_s};
  });
}

Hypothesis LaserByScanAngle(const LidarConfig& lidar, const ScanAngleRange& range) {
  const double first_rad = range.low_rad;
  const double step = (range.high_rad - first_rad) / (kScanAngleBumps - 1);
  return MakeSum<LaserOffset>("laser vectors by scan angle", kScanAngleBumps, kLaserM,
                              [=](const LidarReading& reading, VectorXd* w) {
                                const double angle = ScanAngle(lidar, reading.u_s);
                                for (int k = 0; k < kScanAngleBumps; ++k) {
                                  const double off = (angle - first_rad - step * k) / step;
                                  (*w)[k] = std::exp(-0.5 * off * off);
                                }
                              });
}

Hypothesis LaserByScanAngle(const FlightNetwork& network, std::size_t scanner) {
  const FlightConfig& config = network.flight().config;
  const LidarConfig& lidar = ScannerAt(config, scanner);
  const auto vectors = [k = static_cast<int>(scanner)](const PairEdge& edge) {
    std::vector<Vector3d> own;
    if (edge.pair.scanner_i == k) own.push_back(edge.pair.u_i_s);
    if (edge.pair.scanner_j == k) own.push_back(edge.pair.u_j_s);
    return own;
  };
  Hypothesis laser = LaserByScanAngle(lidar, FindRange(lidar, network.pairs().edges(), vectors));
  if (NumScanners(config) < 2) return laser;
  laser.name += " of scanner " + lidar.name;
  laser.action = OnScanner(std::move(laser.action), scanner);
  return laser;
}

Hypothesis LaserByStrip(const std::vector<StripInterval>& strips) {
  return MakeSumByTime<LaserOffset>("laser vectors by strip", static_cast<int>(strips.size()),
                                    kLaserM, [strips](double t_s, VectorXd* w) {
                                      for (std::size_t k = 0; k < strips.size(); ++k) {
                                        if (t_s < strips[k].t0_s || t_s > strips[k].t1_s) continue;
                                        (*w)[static_cast<Eigen::Index>(k)] = 1.0;
                                      }
                                    });
}

Hypothesis BoresightByCell(const TimeCells& cells) {
  return MakeSumByTime<BoresightTurn>(
      "boresight by time", cells.count(), kBoresightRad,
      [cells](double t_s, VectorXd* w) { (*w)[cells.At(t_s)] = 1.0; });
}

std::vector<double> SettlingTausS(const std::vector<StripInterval>& strips) {
  std::vector<double> taus_s;
  if (strips.empty()) return taus_s;
  const double length_s = strips.back().t1_s - strips.front().t0_s;
  for (const double fraction : kSettlingOfStrips) taus_s.push_back(fraction * length_s);
  return taus_s;
}

Hypothesis BoresightSettling(double begin_s, const std::vector<double>& taus_s) {
  return MakeSumByTime<BoresightTurn>("boresight that settles", static_cast<int>(taus_s.size()),
                                      kBoresightRad, [begin_s, taus_s](double t_s, VectorXd* w) {
                                        for (std::size_t k = 0; k < taus_s.size(); ++k) {
                                          (*w)[static_cast<Eigen::Index>(k)] =
                                              std::exp(-(t_s - begin_s) / taus_s[k]);
                                        }
                                      });
}

Hypothesis BoresightByHeading(const std::vector<StripInterval>& strips,
                              const std::vector<MapPose>& path) {
  TimeCells of_strips;
  std::vector<Eigen::Vector2d> course;
  for (const StripInterval& strip : strips) {
    const MapPose middle = NearestPose(path, 0.5 * (strip.t0_s + strip.t1_s));
    const Vector3d forward = middle.q_mb * Vector3d::UnitX();
    of_strips.start_s.push_back(strip.t0_s);
    course.emplace_back(forward.head<2>().normalized());
  }
  return MakeSumByTime<BoresightTurn>("boresight by heading", 2, kBoresightRad,
                                      [of_strips, course](double t_s, VectorXd* w) {
                                        *w = course[static_cast<std::size_t>(of_strips.At(t_s))];
                                      });
}

Hypothesis GnssByCell(const TimeCells& cells) {
  return MakeSumByTime<GnssShift>("GNSS positions by time", cells.count(), kGnssM,
                                  [cells](double t_s, VectorXd* w) { (*w)[cells.At(t_s)] = 1.0; });
}

Hypothesis GnssByCosine(const Cosines& cosines) {
  return MakeSumByTime<GnssShift>("GNSS positions by frequency", cosines.count, kGnssM,
                                  [cosines](double t_s, VectorXd* w) { *w = cosines.At(t_s); });
}

Hypothesis GnssByBankAndCosine(const Cosines& cosines, const TrajectoryGraph& trajectory,
                               const LocalFrame& frame) {
  const GnssProcess unit{Vector3d::Ones(), 1.0, GnssErrorGrowth::kBank};
  std::vector<double> ratio;  // one per node
  for (std::size_t k = 0; k < trajectory.node_times().size(); ++k) {
    const MapPose pose = trajectory.NodePose(k);
    ratio.push_back(GnssProcessSigma(unit, pose, frame.R_m_enu(pose.p_mb).col(2)).x());
  }
  return MakeSumByTime<GnssShift>(
      "GNSS positions by bank and frequency", cosines.count, kGnssM,
      [cosines, ratio, node_t_s = trajectory.node_times()](double t_s, VectorXd* w) {
        *w = ratio[NodeNear(node_t_s, t_s)] * cosines.At(t_s);
      });
}

}  // namespace dn::diagnosis_internal
