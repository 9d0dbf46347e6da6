#include <dn/lidar/mounting.h>
#include <dn/lidar/strip_io.h>
#include <dn/parallel.h>
#include <dn/sim/random.h>
#include <dn/sim/simulated_clouds.h>
#include <dn/sim/terrain_caster.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "active_effects.h"
#include "beams.h"
#include "echoes.h"
#include "false_returns.h"
#include "fine_poses.h"
#include "scan_pattern.h"
#include "scanner.h"
#include "waves.h"

namespace dn {
namespace {

using Eigen::Vector3d;

constexpr std::size_t kChunkPulses = 16384;
// The time between two groups is then a fraction of a second.
constexpr std::size_t kChunksPerThread = 4;
// The standard deviation across a Gaussian beam is a quarter of its divergence. The divergence is
// the full angle at which the intensity has fallen to 1/e^2.
constexpr double kBeamSigmas = 4.0;
// Sine of 5 deg: flatter pulses graze the ground and do not return.
constexpr double kLeastSink = 0.0872;
constexpr double kLongestRange_m = 20e3;

struct Flown {
  Vector3d middle_m;
  double height_m;  // above the mean ground
  double speed_mps;
};

Flown Fly(const TruthTrajectory& truth, const StripInterval& strip, double base_m) {
  const Vector3d begin_m = truth.Pose(strip.t0_s).p_mb, end_m = truth.Pose(strip.t1_s).p_mb;
  const Vector3d middle_m = 0.5 * (begin_m + end_m);
  return {middle_m, std::max(1.0, middle_m.z() - base_m),
          (end_m - begin_m).norm() / (strip.t1_s - strip.t0_s)};
}

/// Returns the end of the names of random streams of a scanner; empty for a scanner without name.
std::string ScannerSuffix(const LidarScenario& lidar) {
  return lidar.name.empty() ? std::string() : " " + lidar.name;
}

}  // namespace

struct SimulatedClouds::World {
  World(const Scenario& scenario, std::shared_ptr<const TruthTrajectory> truth_given,
        const ActiveEffects& effects_given, const LidarSpan& span_given, std::uint64_t seed_given,
        bool noise_given)
      : lidar(scenario.lidar),
        truth(std::move(truth_given)),
        effects(effects_given),
        span(span_given),
        seed(seed_given),
        noise(noise_given),
        terrain(std::make_shared<const Terrain>(scenario.terrain)),
        base_m(scenario.terrain.base_m),
        scanner(lidar, effects, span, truth, terrain) {
    assumed = lidar.mounting;
    assumed.boresight_rad.setZero();
  }

  LidarScenario lidar;
  Mounting assumed;
  std::shared_ptr<const TruthTrajectory> truth;
  ActiveEffects effects;
  LidarSpan span;
  std::uint64_t seed;
  bool noise;
  std::shared_ptr<const Terrain> terrain;
  double base_m;
  Scanner scanner;
};

/// Simulates the pulses of one strip.
class SimulatedClouds::Pulses {
 public:
  Pulses(const World& world, const StripInterval& strip, std::uint16_t number)
      : world_(world),
        strip_(strip),
        number_(number),
        scan_(MakeScan(world, strip)),
        count_(static_cast<std::size_t>(
            std::ceil((strip.t1_s - strip.t0_s) * world.lidar.pulse_rate_hz))) {}

  std::size_t count() const { return count_; }

  /// Simulates the pulses from `first` to before `past`. The random numbers depend on the chunk.
  /// Without several returns, a pulse is one ray, and a point has no intensity or class.
  CloudCounts Fire(std::size_t chunk, std::size_t first, std::size_t past,
                   StripCloud* cloud) const {
    cloud->Clear();
    Random random(world_.seed, "strip " + strip_.name + " chunk " + std::to_string(chunk) +
                                   ScannerSuffix(world_.lidar));
    TerrainCaster caster(*world_.terrain, number_);
    const FinePoses poses(*world_.truth, Epoch(first), Epoch(past));
    CloudCounts counts{past - first};
    for (std::size_t k = first; k < past; ++k) {
      if (scan_.LooksAway(Since(k))) continue;
      if (world_.lidar.max_returns > 1) {
        FireBeam(k, poses, &random, &caster, &counts, cloud);
      } else {
        Fire(k, poses, &random, &caster, &counts, cloud);
      }
    }
    counts.points = cloud->size();
    return counts;
  }

 private:
  static ScanTiming MakeScan(const World& world, const StripInterval& strip) {
    const Flown flown = Fly(*world.truth, strip, world.base_m);
    const double variation = world.lidar.scan_variation;
    if (variation == 0.0) return {world.lidar, flown.height_m, flown.speed_mps};
    Random random(world.seed, "scan of strip " + strip.name + ScannerSuffix(world.lidar));
    const double stretch = std::max(0.5, 1.0 + variation * random.Normal());
    return {world.lidar, flown.height_m, flown.speed_mps, stretch, 2.0 * random.Uniform()};
  }

  double Since(std::size_t k) const { return static_cast<double>(k) / world_.lidar.pulse_rate_hz; }
  double Epoch(std::size_t k) const { return strip_.t0_s + Since(k); }

  /// Returns the number of the beam of a rotating scanner that fires pulse k.
  int BeamNumber(std::size_t k) const {
    const auto beams = static_cast<std::size_t>(world_.lidar.beams.count());
    return beams == 0 ? kNoBeam : static_cast<int>(k % beams);
  }

  /// Returns the true direction of the centre of the beam, in the sensor frame.
  Vector3d Beam(std::size_t k) const {
    Vector3d nominal_s = scan_.Direction(Since(k));
    double lean_rad = ScanLean(world_.effects, world_.lidar, nominal_s);
    const int beam = BeamNumber(k);
    if (beam != kNoBeam) lean_rad += TrueBeamAngle(world_.lidar.beams, beam);
    if (lean_rad == 0.0) return nominal_s;
    return TurnedTowardAxis(world_.lidar.scan_axis_s.normalized(), lean_rad, nominal_s);
  }

  /// Draws a direction within the footprint, from which the return comes.
  Vector3d InFootprint(const Vector3d& beam_s, Random* random) const {
    if (!world_.noise) return beam_s;
    const double sigma_rad = world_.lidar.beam_divergence_rad / kBeamSigmas;
    const Vector3d one = beam_s.unitOrthogonal(), other = beam_s.cross(one);
    const double x = random->Normal(), y = random->Normal();
    return (beam_s + sigma_rad * (x * one + y * other)).normalized();
  }

  Vector3d Measured(const Vector3d& true_u_s, double t_s, int beam, Random* random) const {
    Vector3d u_s = ReportedByBeam(world_.lidar, beam, true_u_s);
    for (const auto& measured : world_.effects.laser_vector) u_s = measured(u_s, t_s);
    if (!world_.noise) return u_s;
    return (1.0 + world_.lidar.sigma_range_m * random->Normal() / u_s.norm()) * u_s;
  }

  double Tag(double t_s) const {
    double tag_s = t_s;
    for (const auto& shift_s : world_.effects.lidar_tag_shift_s) tag_s += shift_s(t_s, world_.span);
    return tag_s;
  }

  /// Returns the pose that software with this time tag uses.
  MapPose PoseAtTag(double tag_s, const MapPose& true_pose) const {
    if (tag_s == true_pose.t_s) return true_pose;
    const TruthTrajectory& truth = *world_.truth;
    return truth.Pose(std::clamp(tag_s, truth.t_begin_s(), truth.t_end_s()));
  }

  void Fire(std::size_t k, const FinePoses& poses, Random* random, TerrainCaster* caster,
            CloudCounts* counts, StripCloud* cloud) const {
    const double t_s = Epoch(k);
    const MapPose pose = poses.At(t_s);
    const Eigen::Matrix3d R_mb = pose.q_mb.toRotationMatrix();
    const Vector3d beam_s = Beam(k);
    const Vector3d ray_m = R_mb * (world_.scanner.R_bs(t_s) * InFootprint(beam_s, random));
    if (ray_m.z() > -kLeastSink) return;
    const Vector3d origin_m = pose.p_mb + R_mb * world_.scanner.lever_arm_b_m();
    const auto hit = caster->Cast(origin_m, ray_m, kLongestRange_m);
    const bool on_water = hit && hit->surface == Surface::kWater;
    if (on_water) ++counts->on_water;
    if (!hit || on_water) return;
    AddPoint(pose, hit->range_m * beam_s, BeamNumber(k), random, cloud);
  }

  /// Adds the point that software computes from a laser vector.
  void AddPoint(const MapPose& pose, const Vector3d& true_u_s, int beam, Random* random,
                StripCloud* cloud) const {
    const Vector3d u_s = Measured(true_u_s, pose.t_s, beam, random);
    if (beam != kNoBeam) cloud->beam.push_back(static_cast<std::uint16_t>(beam));
    const double tag_s = Tag(pose.t_s);
    cloud->t_s.push_back(tag_s);
    cloud->u_s.push_back(u_s);
    cloud->p_c.push_back(Georeference(PoseAtTag(tag_s, pose), world_.assumed, u_s));
    cloud->source.push_back(number_);
  }

  /// Returns the directions of parts of the beam with equal energy: its centre and a ring around
  /// it, at a random angle. Their mean square distance is that of a Gaussian beam.
  std::array<Vector3d, kBeamParts> BeamParts(const Vector3d& beam_s, Random* random) const {
    constexpr double kRing = 1.5811;  // sigmas: 4/5 of its square is 2
    const double radius_rad = kRing * world_.lidar.beam_divergence_rad / kBeamSigmas;
    const Vector3d one = beam_s.unitOrthogonal(), other = beam_s.cross(one);
    const double turn = random->Uniform(0.0, 0.5 * std::numbers::pi);
    const Vector3d x = radius_rad * (std::cos(turn) * one + std::sin(turn) * other);
    const Vector3d y = radius_rad * (std::cos(turn) * other - std::sin(turn) * one);
    return {beam_s, (beam_s + x).normalized(), (beam_s - x).normalized(), (beam_s + y).normalized(),
            (beam_s - y).normalized()};
  }

  /// Casts the parts of a beam, and returns what the receiver detects.
  Echoes Receive(const Vector3d& origin_m, const Eigen::Matrix3d& R_ms, const Vector3d& beam_s,
                 double t_s, Random* random, TerrainCaster* caster, bool* on_water) const {
    const bool wide = world_.noise && world_.lidar.beam_divergence_rad > 0.0;
    const std::size_t parts = wide ? kBeamParts : 1;
    Echoes echoes;
    const auto beams_s = BeamParts(beam_s, random);
    for (std::size_t k = 0; k < parts; ++k) {
      const Vector3d ray_m = R_ms * beams_s[k];
      if (ray_m.z() > -kLeastSink) continue;
      auto hit = caster->Cast(origin_m, ray_m, kLongestRange_m);
      if (!hit) continue;
      if (hit->surface == Surface::kWater) {
        *on_water = true;
        const Vector3d place_m = origin_m + hit->range_m * ray_m;
        hit->range_m += WaveHeight(place_m.head<2>(), t_s) / ray_m.z();
      }
      echoes.Add({hit->range_m, EchoEnergy(*hit, 1.0 / static_cast<double>(parts)), hit->surface});
    }
    return Detected(echoes, world_.lidar.range_resolution_m, world_.lidar.max_returns);
  }

  void FireBeam(std::size_t k, const FinePoses& poses, Random* random, TerrainCaster* caster,
                CloudCounts* counts, StripCloud* cloud) const {
    const double t_s = Epoch(k);
    const MapPose pose = poses.At(t_s);
    const Eigen::Matrix3d R_mb = pose.q_mb.toRotationMatrix();
    const Vector3d origin_m = pose.p_mb + R_mb * world_.scanner.lever_arm_b_m();
    const Vector3d beam_s = Beam(k);
    bool on_water = false;
    const Echoes echoes =
        Receive(origin_m, R_mb * world_.scanner.R_bs(t_s), beam_s, t_s, random, caster, &on_water);
    if (on_water && echoes.count == 0) ++counts->on_water;
    std::vector<Return> returns;
    for (std::size_t i = 0; i < echoes.count; ++i) {
      returns.push_back(MakeReturn(echoes.list[i], scan_.height_m()));
    }
    if (world_.noise && random->Uniform() < world_.lidar.noise_share) {
      AddFalseReturn(scan_.height_m(), random, &returns);
    }
    for (std::size_t i = 0; i < returns.size(); ++i) {
      AddPoint(pose, returns[i].range_m * beam_s, BeamNumber(k), random, cloud);
      cloud->intensity.push_back(returns[i].intensity);
      cloud->classification.push_back(returns[i].point_class);
      cloud->flags.push_back(returns[i].flags);
      cloud->return_number.push_back(static_cast<std::uint8_t>(i + 1));
      cloud->returns_after.push_back(static_cast<std::uint8_t>(returns.size() - i - 1));
    }
  }

  const World& world_;
  const StripInterval& strip_;
  std::uint16_t number_;
  ScanTiming scan_;
  std::size_t count_;
};

SimulatedClouds::SimulatedClouds(const Scenario& scenario, std::vector<StripInterval> strips,
                                 std::shared_ptr<const TruthTrajectory> truth,
                                 const ActiveEffects& effects, const LidarSpan& span,
                                 std::uint64_t seed, bool noise)
    : strips_(std::move(strips)),
      world_(
          std::make_unique<const World>(scenario, std::move(truth), effects, span, seed, noise)) {}

SimulatedClouds::~SimulatedClouds() = default;

CloudCounts SimulatedClouds::Run(std::size_t strip, int threads,
                                 const std::function<void(const StripCloud&)>& take,
                                 const std::function<void(double)>& progress) const {
  const Pulses pulses(*world_, strips_[strip], static_cast<std::uint16_t>(strip + 1));
  const std::size_t chunks = kChunksPerThread * static_cast<std::size_t>(std::max(1, threads));
  const std::size_t at_once = chunks * kChunkPulses;
  std::vector<StripCloud> clouds(chunks);
  std::vector<CloudCounts> each(chunks);
  CloudCounts counts;
  for (std::size_t begin = 0; begin < pulses.count(); begin += at_once) {
    const std::size_t now = std::min(at_once, pulses.count() - begin);
    ParallelForChunks(now, kChunkPulses, threads,
                      [&](std::size_t chunk, std::size_t first, std::size_t past) {
                        each[chunk] = pulses.Fire(begin / kChunkPulses + chunk, begin + first,
                                                  begin + past, &clouds[chunk]);
                      });
    for (std::size_t chunk = 0; chunk < NumChunks(now, kChunkPulses); ++chunk) {
      take(clouds[chunk]);
      counts.pulses += each[chunk].pulses;
      counts.points += each[chunk].points;
      counts.on_water += each[chunk].on_water;
    }
    if (progress) {
      progress(static_cast<double>(begin + now) / static_cast<double>(pulses.count()));
    }
  }
  return counts;
}

CloudCounts SimulatedClouds::Write(std::size_t strip, const std::filesystem::path& file,
                                   int threads, const std::function<void(double)>& progress) const {
  const Flown flown = Fly(*world_->truth, strips_[strip], world_->base_m);
  const auto writer = NewLasStrip(file, {.offset_m = flown.middle_m.array().round()},
                                  world_->lidar.beams.count() > 0);
  const CloudCounts counts = Run(
      strip, threads, [&](const StripCloud& cloud) { writer->Append(cloud); }, progress);
  writer->Finish();
  return counts;
}

}  // namespace dn
