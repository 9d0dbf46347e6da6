#include <dn/files/flight_config.h>
#include <dn/imu/unknown_imu.h>

#include <cmath>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::files_test {

using ::testing::HasSubstr;
using testing::TempFolder;

constexpr double kDeg = 3.14159265358979323846 / 180.0;
constexpr double kRelative = 1e-14;  // allows for a few roundings of a unit conversion

FlightConfig Parse(const std::string& text) { return ParseFlightConfig(text, "/flights/one"); }

/// Every key with a value other than its default.
const char* const kEveryKey = R"(
name: "a \"quoted\" name"
body: FRD
frame: {origin_deg_m: [46.57, 6.52, 12.5]}
time_span_s: [381000.1, 382000.7]
strips: [{name: "1", t0: 381100.1, t1: 381200.3}, {name: b, t0: 381300, t1: 381400}]
strips_crs: utm:32n
imu:
  file: imu.dat
  format: increments
  sampling: instantaneous
  rate_unit: deg/s
  force_unit: g
  R_imu_to_body: [[0, 1, 0], [1, 0, 0], [0, 0, -1]]
  time_offset_s: 0.013
  grade: apx15
  gyro:
    white_deg_sqrt_h: 0.17
    processes:
      - {type: random_constant, sigma_deg_h: 13}
      - {type: gauss_markov, sigma_deg_h: 1.7, tau_s: 333}
      - {type: random_walk, sigma_deg_h_sqrt_h: 1e-1}
  accel:
    white_m_s_sqrt_h: 0.07
    processes:
      - {type: gauss_markov, sigma_mg: 0.07, tau_s: 3e2}
      - {type: random_walk, sigma_mg_sqrt_h: 0.03}
  vibration:
    - {window_s: [381100.7, 381150.1], sigma_gyro_deg_s: 0.17, sigma_accel_m_s2: 0.3}
    - {window_s: [381140, 381200], sigma_accel_m_s2: 0.07}
gnss:
  file: rover.pos
  format: ob_gins
  crs: utm:32n
  north: grid
  time_offset_s: -18
  lever_arm_m: [0.4, -0.1, -1.1]
  sigma_enu_m: [0.01, 0.02, 0.03]
  sigma_scale: 1.7
  velocity_sigma_scale: 2.3
  use_velocity: false
  processes:
    - {type: gauss_markov, sigma_enu_m: [0.011, 0.012, 0.023], tau_s: 123.4}
    - {type: gauss_markov, sigma_enu_m: [0, 0, 0.3], tau_s: 3e3, grows_with: bank}
    - {type: gauss_markov, sigma_enu_m: [0, 0, 0.4], tau_s: 5, grows_with: none}
  robust: huber
lidar:
  p2p: [a.txt, "lidar/*.txt"]
  time_offset_s: 0.1
  pairs: {strategy: max, count: 300, freq_hz: 0.7, window_s: 3.3, seed: 7}
  R_sensor_to_body: [[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1]]
  lever_arm_m: [0.14, -0.02, 0.21]
  boresight_deg: [0.2, 0.03, 0.35]
  boresight_sigma_deg: [0.1, 0.2, 0.3]
  georeferenced_with: {boresight_deg: [0.3, -0.1, 1.7]}
  scan_axis: [0, 1, 0]
  nadir_axis: [0.6, 0, 0.8]
  gsd_m: 0.2
  sigma_p_m: 0.057735
  robust: cauchy
trajectory: {file: t.txt, crs: "utm:32n", attitude: roll_pitch_heading_deg, north: grid,
             sigma_xy_m: 0.0022, sigma_z_m: 0.0039, sigma_rp_deg: 0.00022, sigma_y_deg: 0.00058}
gh: {rotation: small_angle, libor_compat: true}
unmodelled: {gyro_misalignment: 0.03, lidar_lever_arm: [0.01, 0, 0.02]}
estimate: [boresight, {unknown: gnss_lever_arm, sigma: 0.05}, lidar_time_offset,
           {unknown: boresight_step, t0_s: 381500, sigma: [0.01, 0.02, 0.03]},
           {unknown: gnss_position_step, window_s: [381400, 381450.5]}, gravity_tilt]
network: {inertial: raw, node_rate_hz: 12.5}
)";

void ExpectSameNoise(const SensorNoise& a, const SensorNoise& b) {
  EXPECT_EQ(a.white, b.white);
  ASSERT_EQ(a.processes.size(), b.processes.size());
  for (std::size_t i = 0; i < a.processes.size(); ++i) {
    EXPECT_EQ(a.processes[i].type, b.processes[i].type);
    EXPECT_EQ(a.processes[i].sigma, b.processes[i].sigma);
    EXPECT_EQ(a.processes[i].tau_s, b.processes[i].tau_s);
  }
}

void ExpectSameSensors(const FlightConfig& a, const FlightConfig& b) {
  ASSERT_EQ(a.imu.has_value(), b.imu.has_value());
  if (a.imu) {
    EXPECT_EQ(a.imu->file, b.imu->file);
    EXPECT_EQ(a.imu->read.format, b.imu->read.format);
    EXPECT_EQ(a.imu->read.sampling, b.imu->read.sampling);
    EXPECT_EQ(a.imu->read.rate_unit_radps, b.imu->read.rate_unit_radps);
    EXPECT_EQ(a.imu->read.force_unit_mps2, b.imu->read.force_unit_mps2);
    EXPECT_EQ(a.imu->read.R_imu_to_body, b.imu->read.R_imu_to_body);
    EXPECT_EQ(a.imu->read.time_offset_s, b.imu->read.time_offset_s);
    EXPECT_EQ(a.imu->read.t_begin_s, b.imu->read.t_begin_s);
    EXPECT_EQ(a.imu->read.t_end_s, b.imu->read.t_end_s);
    EXPECT_EQ(a.imu->grade, b.imu->grade);
    EXPECT_EQ(a.imu->model.name, b.imu->model.name);
    EXPECT_EQ(a.imu->model.source, b.imu->model.source);
    ExpectSameNoise(a.imu->model.gyro, b.imu->model.gyro);
    ExpectSameNoise(a.imu->model.accel, b.imu->model.accel);
    EXPECT_EQ(a.imu->model.vibration, b.imu->model.vibration);
  }
  ASSERT_EQ(a.gnss.has_value(), b.gnss.has_value());
  if (a.gnss) {
    EXPECT_EQ(a.gnss->file, b.gnss->file);
    EXPECT_EQ(a.gnss->format, b.gnss->format);
    EXPECT_EQ(a.gnss->crs, b.gnss->crs);
    EXPECT_EQ(a.gnss->grid_north, b.gnss->grid_north);
    EXPECT_EQ(a.gnss->time_offset_s, b.gnss->time_offset_s);
    EXPECT_EQ(a.gnss->lever_arm_b_m, b.gnss->lever_arm_b_m);
    EXPECT_EQ(a.gnss->sigma_enu_m, b.gnss->sigma_enu_m);
    EXPECT_EQ(a.gnss->sigma_scale, b.gnss->sigma_scale);
    EXPECT_EQ(a.gnss->velocity_sigma_scale, b.gnss->velocity_sigma_scale);
    EXPECT_EQ(a.gnss->use_velocity, b.gnss->use_velocity);
    EXPECT_EQ(a.gnss->processes, b.gnss->processes);
    EXPECT_EQ(a.gnss->automatic_process, b.gnss->automatic_process);
    EXPECT_EQ(a.gnss->robust, b.gnss->robust);
  }
}

void ExpectSameLidar(const LidarConfig& a, const LidarConfig& b) {
  EXPECT_EQ(a.p2p, b.p2p);
  EXPECT_EQ(a.time_offset_s, b.time_offset_s);
  EXPECT_EQ(a.pairs.strategy, b.pairs.strategy);
  EXPECT_EQ(a.pairs.count, b.pairs.count);
  EXPECT_EQ(a.pairs.freq_hz, b.pairs.freq_hz);
  EXPECT_EQ(a.pairs.window_s, b.pairs.window_s);
  EXPECT_EQ(a.pairs.seed, b.pairs.seed);
  EXPECT_EQ(a.mounting.R_bs_nominal, b.mounting.R_bs_nominal);
  EXPECT_EQ(a.mounting.lever_arm_b_m, b.mounting.lever_arm_b_m);
  EXPECT_EQ(a.mounting.boresight_rad, b.mounting.boresight_rad);
  EXPECT_EQ(a.boresight_sigma_rad, b.boresight_sigma_rad);
  EXPECT_EQ(a.georeferenced_with_rad, b.georeferenced_with_rad);
  EXPECT_EQ(a.scan_axis_s, b.scan_axis_s);
  EXPECT_EQ(a.nadir_axis_s, b.nadir_axis_s);
  EXPECT_EQ(a.gsd_m, b.gsd_m);
  EXPECT_EQ(a.sigma_p_m, b.sigma_p_m);
  EXPECT_EQ(a.robust, b.robust);
}

void ExpectSameRest(const FlightConfig& a, const FlightConfig& b) {
  EXPECT_EQ(a.name, b.name);
  ASSERT_EQ(a.origin.has_value(), b.origin.has_value());
  if (a.origin) {
    EXPECT_EQ(a.origin->lat_rad, b.origin->lat_rad);
    EXPECT_EQ(a.origin->lon_rad, b.origin->lon_rad);
    EXPECT_EQ(a.origin->h_m, b.origin->h_m);
  }
  EXPECT_EQ(a.time_span_s, b.time_span_s);
  ASSERT_EQ(a.strips.size(), b.strips.size());
  for (std::size_t i = 0; i < a.strips.size(); ++i) {
    EXPECT_EQ(a.strips[i].name, b.strips[i].name);
    EXPECT_EQ(a.strips[i].t0_s, b.strips[i].t0_s);
    EXPECT_EQ(a.strips[i].t1_s, b.strips[i].t1_s);
  }
  EXPECT_EQ(a.strips_crs, b.strips_crs);
  ASSERT_EQ(a.trajectory.has_value(), b.trajectory.has_value());
  if (a.trajectory) {
    EXPECT_EQ(a.trajectory->file, b.trajectory->file);
    EXPECT_EQ(a.trajectory->columns.crs, b.trajectory->columns.crs);
    EXPECT_EQ(a.trajectory->columns.attitude, b.trajectory->columns.attitude);
    EXPECT_EQ(a.trajectory->columns.grid_north, b.trajectory->columns.grid_north);
    EXPECT_EQ(a.trajectory->sigma_xy_m, b.trajectory->sigma_xy_m);
    EXPECT_EQ(a.trajectory->sigma_z_m, b.trajectory->sigma_z_m);
    EXPECT_EQ(a.trajectory->sigma_rp_rad, b.trajectory->sigma_rp_rad);
    EXPECT_EQ(a.trajectory->sigma_y_rad, b.trajectory->sigma_y_rad);
  }
  EXPECT_EQ(a.gh.exponential, b.gh.exponential);
  EXPECT_EQ(a.gh.libor_compat, b.gh.libor_compat);
  EXPECT_EQ(a.unmodelled.none, b.unmodelled.none);
  ASSERT_EQ(a.unmodelled.sizes.size(), b.unmodelled.sizes.size());
  for (std::size_t i = 0; i < a.unmodelled.sizes.size(); ++i) {
    EXPECT_EQ(a.unmodelled.sizes[i].effect, b.unmodelled.sizes[i].effect);
    EXPECT_EQ(a.unmodelled.sizes[i].sigma, b.unmodelled.sizes[i].sigma);
  }
  ASSERT_EQ(a.estimate.size(), b.estimate.size());
  for (std::size_t i = 0; i < a.estimate.size(); ++i) {
    EXPECT_EQ(a.estimate[i].unknown, b.estimate[i].unknown);
    EXPECT_EQ(a.estimate[i].sigma, b.estimate[i].sigma);
    EXPECT_EQ(a.estimate[i].times.window_s, b.estimate[i].times.window_s);
    EXPECT_EQ(a.estimate[i].times.t0_s, b.estimate[i].times.t0_s);
  }
  EXPECT_EQ(a.network.inertial, b.network.inertial);
  EXPECT_EQ(a.network.node_rate_hz, b.network.node_rate_hz);
  EXPECT_EQ(a.unexplained, b.unexplained);
}

void ExpectRoundTrip(const FlightConfig& config) {
  const std::string text = FormatFlightConfig(config);
  SCOPED_TRACE(text);
  const FlightConfig again = ParseFlightConfig(text, config.folder);
  ExpectSameSensors(config, again);
  ASSERT_EQ(config.lidar.has_value(), again.lidar.has_value());
  if (config.lidar) ExpectSameLidar(*config.lidar, *again.lidar);
  ExpectSameRest(config, again);
}

TEST(FlightConfig, AnEmptyMapTakesEveryDefault) {
  const FlightConfig config = Parse("{}");
  EXPECT_EQ(config.name, "one");
  EXPECT_FALSE(config.body_is_flu || config.imu || config.gnss || config.lidar);
  EXPECT_EQ(config.strips_crs, "map");
  ASSERT_EQ(config.estimate.size(), 1u);
  EXPECT_EQ(config.estimate[0].unknown, "boresight");
  EXPECT_FALSE(config.network.node_rate_hz);
}

TEST(FlightConfig, ConvertsEveryKeyToSi) {
  const FlightConfig c = Parse(kEveryKey);
  EXPECT_EQ(c.name, "a \"quoted\" name");
  EXPECT_NEAR(c.origin->lat_rad, 46.57 * kDeg, kRelative);
  EXPECT_EQ(c.imu->read.t_begin_s, 381000.1);
  EXPECT_EQ(c.imu->read.t_end_s, 382000.7);
  EXPECT_NEAR(c.imu->model.gyro.white, 0.17 * kDeg / 60.0, kRelative);
  EXPECT_NEAR(c.imu->model.gyro.processes[0].sigma, 13.0 * kDeg / 3600.0, kRelative);
  EXPECT_NEAR(c.imu->model.gyro.processes[2].sigma, 0.1 * kDeg / 3600.0 / 60.0, kRelative);
  EXPECT_NEAR(c.imu->model.accel.white, 0.07 / 60.0, kRelative);
  EXPECT_NEAR(c.imu->model.accel.processes[0].sigma, 0.07e-3 * 9.80665, kRelative);
  EXPECT_EQ(c.imu->model.accel.processes[0].tau_s, 300.0);
  ASSERT_EQ(c.imu->model.vibration.size(), 2U);
  EXPECT_NEAR(c.imu->model.vibration[0].gyro_sigma_radps, 0.17 * kDeg, kRelative);
  EXPECT_EQ(c.imu->model.vibration[0].accel_sigma_mps2, 0.3);
  EXPECT_EQ(c.imu->model.vibration[1], (ImuVibration{381140.0, 381200.0, 0.0, 0.07}));
  EXPECT_EQ(c.gnss->lever_arm_b_m, Eigen::Vector3d(0.4, -0.1, -1.1));
  EXPECT_EQ(c.gnss->use_velocity, std::optional<bool>(false));
  ASSERT_EQ(c.gnss->processes.size(), 3U);
  EXPECT_EQ(c.gnss->processes[0], (GnssProcess{{0.011, 0.012, 0.023}, 123.4}));
  EXPECT_EQ(c.gnss->processes[1], (GnssProcess{{0.0, 0.0, 0.3}, 3000.0, GnssErrorGrowth::kBank}));
  EXPECT_EQ(c.gnss->processes[2], (GnssProcess{{0.0, 0.0, 0.4}, 5.0}));
  EXPECT_NEAR(c.lidar->mounting.boresight_rad.z(), 0.35 * kDeg, kRelative);
  EXPECT_NEAR(c.lidar->boresight_sigma_rad->y(), 0.2 * kDeg, kRelative);
  EXPECT_NEAR(c.trajectory->sigma_y_rad, 0.00058 * kDeg, kRelative);
  EXPECT_FALSE(c.gh.exponential);
  EXPECT_EQ(c.estimate[1].sigma, std::vector<double>{0.05});
  EXPECT_EQ(c.estimate[3].times.t0_s, 381500.0);
  EXPECT_EQ(c.estimate[4].times.window_s, std::pair(381400.0, 381450.5));
  EXPECT_LT((*PriorSigma(c.estimate[3]) - kDeg * Eigen::Vector3d(0.01, 0.02, 0.03)).norm(), 1e-15);
  EXPECT_EQ(*PriorSigma(c.estimate[1]), Eigen::Vector3d::Constant(0.05));
  EXPECT_EQ(PriorSigma(c.estimate[2]), std::nullopt);
  ASSERT_EQ(c.unmodelled.sizes.size(), 2u);
  EXPECT_EQ(c.unmodelled.sizes[0].effect, EffectId::kGyroMisalignment);
  EXPECT_EQ(c.unmodelled.sizes[1].sigma, (std::vector<double>{0.01, 0.0, 0.02}));
  EXPECT_EQ(c.network.inertial, NetworkConfig::Inertial::kRaw);
}

TEST(FlightConfig, EveryFixedEffectMayBeEstimatedWithAPrior) {
  for (const EffectSpec& effect : EffectTable()) {
    if (effect.kind != EffectKind::kFixed) continue;
    const std::string key = TimingKey(effect.timing);
    const std::string timing = key.empty()         ? ""
                               : key == "window_s" ? ", window_s: [5, 6]"
                                                   : ", t0_s: 5";
    const FlightConfig config =
        Parse("estimate: [{unknown: " + effect.name + ", sigma: 3" + timing + "}]\n");
    ASSERT_EQ(config.estimate.size(), 1u);
    const std::vector<double> three(effect.components.size(), 3.0);
    EXPECT_EQ(*PriorSigma(config.estimate[0]), ValueInSi(effect, three)) << effect.name;
    EXPECT_EQ(config.estimate[0].where.line, 1);
    ExpectRoundTrip(config);
  }
}

TEST(FlightConfig, ReadsBackWhatItFormats) {
  ExpectRoundTrip(Parse(kEveryKey));
  ExpectRoundTrip(Parse("{}"));
  ExpectRoundTrip(Parse("{imu: {grade: ln200}, gnss: {}, lidar: {gsd_m: 0.3}, trajectory: {}}"));
  ExpectRoundTrip(Parse("unmodelled: none"));
  ExpectRoundTrip(Parse("gnss: {processes: auto}"));
  ExpectRoundTrip(Parse("gnss: {processes: []}"));
  ExpectRoundTrip(Parse("{estimate: []}"));
  ExpectRoundTrip(Parse("{unexplained: 'all of a gap (p < 1e-12), most in \"GNSS\": east'}"));
  ExpectRoundTrip(ParseFlightConfig("name: x", "/f"));
}

TEST(FlightConfig, ReadsBackEveryPreset) {
  for (const std::string& name : ImuPresetNames()) {
    SCOPED_TRACE(name);
    ExpectRoundTrip(Parse("imu: {grade: " + name + "}"));
  }
}

TEST(FlightConfig, ResolvesThePairNoiseFromTheGroundSamplingDistance) {
  EXPECT_NEAR(Parse("lidar: {gsd_m: 0.2}").lidar->sigma_p_m, 0.2 / 2.0 / std::sqrt(3.0), kRelative);
  EXPECT_EQ(Parse("lidar: {gsd_m: 0.2, sigma_p_m: 0.1}").lidar->sigma_p_m, 0.1);
}

TEST(FlightConfig, AcceptsOneBoresightSigmaForAllAxes) {
  const FlightConfig config = Parse("lidar: {gsd_m: 0.2, boresight_sigma_deg: 1.0}");
  EXPECT_NEAR((*config.lidar->boresight_sigma_rad - Eigen::Vector3d::Constant(kDeg)).norm(), 0.0,
              kRelative);
}

TEST(FlightConfig, TheStripsWereGeoreferencedWithABoresight) {
  const auto declared = [](const std::string& more) {
    return Parse("{" + more + "}").lidar->georeferenced_with_rad;
  };
  const std::string begin = "lidar: {gsd_m: 0.2, boresight_deg: [0.1, 0.2, 0.3]";
  EXPECT_FALSE(declared(begin + "}"));
  EXPECT_FALSE(declared(begin + ", georeferenced_with: ~}"));
  const Eigen::Vector3d same_rad = kDeg * Eigen::Vector3d(0.1, 0.2, 0.3);
  EXPECT_LE((*declared(begin + ", georeferenced_with: boresight}") - same_rad).norm(), kRelative);
  const std::string angles = ", georeferenced_with: {boresight_deg: [1, 2, -3]}";
  const Eigen::Vector3d other_rad = kDeg * Eigen::Vector3d(1, 2, -3);
  EXPECT_LE((*declared(begin + angles + "}") - other_rad).norm(), kRelative);
  const Eigen::Vector3d flipped_rad = kDeg * Eigen::Vector3d(1, -2, 3);
  const std::string flu =
      "body: FLU, " + begin + ", R_sensor_to_body: [[1, 0, 0], [0, -1, 0], [0, 0, -1]]";
  EXPECT_LE((*declared(flu + angles + "}") - flipped_rad).norm(), kRelative);
}

TEST(FlightConfig, TreatsTildeAsAbsent) {
  const FlightConfig config = Parse(
      "{frame: ~, time_span_s: ~, strips: ~, imu: ~, gnss: {lever_arm_m: ~, robust: ~},"
      " lidar: {gsd_m: 1e-1, sigma_p_m: ~, boresight_sigma_deg: ~}, network: {node_rate_hz: ~}}");
  EXPECT_FALSE(config.imu);
  EXPECT_EQ(config.gnss->lever_arm_b_m, Eigen::Vector3d::Zero());
  EXPECT_EQ(config.lidar->gsd_m, std::optional<double>(0.1));
  EXPECT_FALSE(config.lidar->boresight_sigma_rad);
}

TEST(FlightConfig, OverridesAPresetBySensorAndPart) {
  const ImuModel preset = ImuPreset("ln200");
  const FlightConfig config = Parse(
      "imu: {grade: ln200, gyro: {white_deg_sqrt_h: 0.5},"
      " accel: {processes: [{type: random_constant, sigma_mg: 2}]}}");
  const ImuModel& model = config.imu->model;
  EXPECT_NEAR(model.gyro.white, 0.5 * kDeg / 60.0, kRelative);
  EXPECT_EQ(model.gyro.processes.size(), preset.gyro.processes.size());
  EXPECT_EQ(model.accel.white, preset.accel.white);
  ASSERT_EQ(model.accel.processes.size(), 1u);
  EXPECT_NEAR(model.accel.processes[0].sigma, 2e-3 * 9.80665, kRelative);
  EXPECT_EQ(model.source, "flight.yaml");
}

TEST(FlightConfig, KeepsThePresetsSourceWhenNothingIsOverridden) {
  EXPECT_EQ(Parse("imu: {grade: airins}").imu->model.source, ImuPreset("airins").source);
}

TEST(FlightConfig, AnUnknownGradeStartsWithTheStatedFigures) {
  const FlightConfig bare = Parse("imu: {grade: unknown}");
  EXPECT_EQ(bare.imu->grade, kUnknownGrade);
  EXPECT_EQ(bare.imu->model.gyro.white, UnknownImu().gyro.white);
  const FlightConfig stated = Parse("imu: {grade: unknown, gyro: {white_deg_sqrt_h: 0.002}}");
  EXPECT_NEAR(stated.imu->model.gyro.white, 0.002 * kDeg / 60.0, kRelative);
  ExpectRoundTrip(stated);
  // The class follows from the noise, as without a grade.
  EXPECT_DOUBLE_EQ(MakeUnmodelledPrior(bare).Sigma(EffectId::kGyroMisalignment)[0], 0.2e-3);
  EXPECT_DOUBLE_EQ(MakeUnmodelledPrior(stated).Sigma(EffectId::kGyroMisalignment)[0], 0.03e-3);
}

const char* const kForwardLeftUp = R"(
body: FLU
imu: {grade: ln200}
gnss: {lever_arm_m: [0.4, 0.1, 1.1]}
lidar:
  R_sensor_to_body: [[1, 0, 0], [0, -1, 0], [0, 0, -1]]
  lever_arm_m: [1, 2, 3]
  boresight_deg: [0.1, 0.2, 0.3]
  boresight_sigma_deg: [1, 2, 3]
  gsd_m: 0.2
)";

TEST(FlightConfig, ConvertsBodyQuantitiesFromForwardLeftUp) {
  const FlightConfig c = Parse(kForwardLeftUp);
  EXPECT_EQ(c.imu->read.R_imu_to_body.diagonal(), Eigen::Vector3d(1, -1, -1));
  EXPECT_EQ(c.gnss->lever_arm_b_m, Eigen::Vector3d(0.4, -0.1, -1.1));
  EXPECT_EQ(c.lidar->mounting.R_bs_nominal, Eigen::Matrix3d::Identity());
  EXPECT_EQ(c.lidar->mounting.lever_arm_b_m, Eigen::Vector3d(1, -2, -3));
  const Eigen::Vector3d boresight_rad = kDeg * Eigen::Vector3d(0.1, -0.2, -0.3);
  EXPECT_LE((c.lidar->mounting.boresight_rad - boresight_rad).norm(), kRelative);
  EXPECT_GT(c.lidar->boresight_sigma_rad->minCoeff(), 0.0);
}

TEST(FlightConfig, FormatsForwardLeftUpAsForwardRightDownAndSaysSo) {
  const FlightConfig c = Parse(kForwardLeftUp);
  const std::string text = FormatFlightConfig(c);
  EXPECT_THAT(text, HasSubstr("body: FRD"));
  EXPECT_THAT(text, HasSubstr("data files remain FLU"));
  ExpectRoundTrip(c);
}

TEST(FlightConfig, ReadsTheFolder) {
  const TempFolder folder;
  folder.Write("flight.yaml", "gnss: {file: g.txt}\n");
  const FlightConfig config = ReadFlightConfig(folder.path());
  EXPECT_EQ(config.folder, folder.path());
  EXPECT_EQ(config.name, folder.path().filename().string());
  EXPECT_EQ(config.gnss->file, "g.txt");
}

TEST(FlightConfig, ReadsAFileUnderAnotherName) {
  const TempFolder folder;
  folder.Write("adapted.yaml", "gnss: {file: g.txt}\n");
  const FlightConfig config = ReadFlightConfig(folder.path() / "adapted.yaml");
  EXPECT_EQ(config.folder, folder.path());
  EXPECT_EQ(config.file, folder.path() / "adapted.yaml");
}

TEST(FlightConfig, FindsItsDataBesideItElseInTheFolderThatItNames) {
  const TempFolder data, other;
  data.Write("g.txt", "");
  const std::string text = "{data_folder: " + data.path().string() + ", gnss: {file: g.txt}}";
  EXPECT_EQ(ParseFlightConfig(text, other.path()).folder, data.path());
  other.Write("g.txt", "");
  EXPECT_EQ(ParseFlightConfig(text, other.path()).folder, other.path());
}

TEST(FlightConfig, AFileForElsewhereNamesTheDataAndKeepsTheirAxes) {
  const TempFolder data, other;
  data.Write("flight.yaml", kForwardLeftUp);
  const FlightConfig config = ReadFlightConfig(data.path());
  data.Write(config.imu->file, "");
  const std::string text = FormatFlightFile(config);
  EXPECT_THAT(text, HasSubstr("body: FLU"));
  const FlightConfig again = ParseFlightConfig(text, other.path());
  EXPECT_EQ(again.folder, data.path());
  EXPECT_EQ(again.imu->read.R_imu_to_body, config.imu->read.R_imu_to_body);
  ExpectSameSensors(config, again);
  ExpectSameLidar(*config.lidar, *again.lidar);
  ExpectSameRest(config, again);
}

TEST(FlightConfig, AcceptsTheAnnotatedExample) {
  const FlightConfig config = ReadFlightConfig(DN_REFERENCE_DIR);
  EXPECT_EQ(config.name, "lar3");
  ASSERT_TRUE(config.imu && config.gnss && config.lidar && config.trajectory);
  EXPECT_EQ(config.imu->model.gyro.processes.size(), 3u);
  ExpectRoundTrip(config);
}

TEST(FlightConfig, TheAnnotatedExampleShowsTheDefaults) {
  const FlightConfig shown = ReadFlightConfig(DN_REFERENCE_DIR);
  FlightConfig plain =
      ParseFlightConfig("{name: lar3, gnss: {}, lidar: {gsd_m: 0.2}, trajectory: {}}", "/f");
  plain.imu = shown.imu;  // its noise has no default
  ExpectSameSensors(shown, plain);
  ExpectSameLidar(*shown.lidar, *plain.lidar);
  ExpectSameRest(shown, plain);
}

TEST(FlightConfig, GnssProcessesAreAutomaticAListOrNone) {
  for (const char* text : {"gnss: {}", "gnss: {processes: auto}", "gnss: {processes: ~}"}) {
    const FlightConfig config = Parse(text);
    EXPECT_TRUE(config.gnss->automatic_process && HasAutomaticGnssProcess(config)) << text;
    EXPECT_TRUE(config.gnss->processes.empty()) << text;
    EXPECT_THAT(FormatFlightConfig(config), HasSubstr("  processes: auto\n")) << text;
  }
  EXPECT_FALSE(HasAutomaticGnssProcess(Parse("gnss: {processes: []}")));
  EXPECT_THAT(FormatFlightConfig(Parse("gnss: {processes: []}")), HasSubstr("  processes: []\n"));
  EXPECT_FALSE(HasAutomaticGnssProcess(
      Parse("gnss: {processes: [{type: gauss_markov, sigma_enu_m: [1, 1, 1], tau_s: 9}]}")));
  EXPECT_FALSE(HasAutomaticGnssProcess(Parse("{gnss: {}, unmodelled: none}")));
  EXPECT_FALSE(HasAutomaticGnssProcess(Parse("{}")));
}

TEST(FlightConfig, UnmodelledEffectsHaveThePriorOfTheSensorAndWhatTheFileStates) {
  const FlightConfig of_class = Parse("imu: {grade: apx15}\nunmodelled: {}\n");
  EXPECT_DOUBLE_EQ(MakeUnmodelledPrior(of_class).Sigma(EffectId::kGyroMisalignment)[0], 0.2e-3);
  const FlightConfig stated = Parse(
      "imu: {grade: apx15}\nunmodelled: {gyro_misalignment: [0.1, 0.1, 0], "
      "lidar_scan_cone: 0}\n");
  const UnmodelledPrior prior = MakeUnmodelledPrior(stated);
  EXPECT_DOUBLE_EQ(prior.Sigma(EffectId::kGyroMisalignment)[0], 0.1e-3);
  EXPECT_EQ(prior.Sigma(EffectId::kGyroMisalignment)[2], 0.0);
  EXPECT_EQ(prior.Sigma(EffectId::kLidarScanCone)[0], 0.0);
  EXPECT_DOUBLE_EQ(prior.Sigma(EffectId::kGyroScaleFactor)[0], 200e-6);
  EXPECT_TRUE(MakeUnmodelledPrior(Parse("unmodelled: none")).pure());
  EXPECT_DOUBLE_EQ(MakeUnmodelledPrior(Parse("{}")).Sigma(EffectId::kGyroMisalignment)[0], 0.03e-3);
}

TEST(FlightConfig, UnitsMayBeNumbers) {
  const FlightConfig config = Parse(
      "imu: {grade: airins, format: increments, columns: [=RAWIMUSA, week, t, fz, -fy, fx, wz, "
      "-wy, "
      "wx], rate_unit: 1.16415e-10, force_unit: 2.27e-9}\n");
  EXPECT_EQ(config.imu->read.rate_unit_radps, 1.16415e-10);
  EXPECT_EQ(config.imu->read.force_unit_mps2, 2.27e-9);
  const FlightConfig again = Parse(FormatFlightConfig(config));
  EXPECT_EQ(again.imu->read.rate_unit_radps, 1.16415e-10);
  EXPECT_EQ(again.imu->read.force_unit_mps2, 2.27e-9);
  EXPECT_EQ(again.imu->read.columns, config.imu->read.columns);
}

TEST(FlightConfig, ChangedRowsAreKept) {
  const FlightConfig config = Parse("gnss: {columns: [t, lat, lon, h], rows: changed}\n");
  EXPECT_TRUE(config.gnss->only_changed);
  EXPECT_TRUE(Parse(FormatFlightConfig(config)).gnss->only_changed);
  EXPECT_FALSE(Parse("gnss: {columns: [t, lat, lon, h], rows: all}\n").gnss->only_changed);
}

}  // namespace dn::files_test
