#include <dn/adjustment/adjust.h>
#include <dn/axis_names.h>
#include <dn/error.h>
#include <dn/geo/local_frame.h>
#include <dn/imu/allan.h>
#include <dn/imu/imu_data.h>
#include <dn/imu/rest_check.h>
#include <dn/report/plot.h>
#include <fmt/format.h>

#include <cmath>

#include "command.h"
#include "option_checks.h"

namespace dn::apps {
namespace {

struct AllanArguments {
  CommonOptions common;
  std::filesystem::path file;
  double rate_hz = 0.0;
  std::string format = "odyn";
  std::string rate_unit = "rad/s", force_unit = "m/s^2";
  ColumnNames columns;
  std::string body = "FRD";
};

// Largest relative difference between --rate and the rate of the time tags. A larger one indicates
// another file or another sensor.
constexpr double kRateTolerance = 0.01;

/// Accepts one name of a column.
CLI::Validator ColumnName() {
  const auto check = [](const std::string& name) {
    try {
      const bool is_time = HasColumn({name}, "t");
      CheckColumnNames(is_time ? ColumnNames{name} : ColumnNames{"t", name}, ImuQuantities());
    } catch (const InvalidInput& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  return {check, ""};
}

/// Units of one sensor, as flight.yaml uses them.
struct SensorUnits {
  const char* name;
  double rate_per_si;  ///< deg/h per rad/s; mg per m/s^2
  const char* rate_unit;
  double white_per_si;  ///< deg/sqrt(h) per rad/sqrt(s); m/s/sqrt(h) per m/s/sqrt(s)
  const char* white_unit;
  const char* white_key;
  const char* sigma_key;
  const char* walk_key;
};

const SensorUnits kGyro{"gyro",        3600.0 * kDegPerRad, "deg/h",       60.0 * kDegPerRad,
                        "deg/sqrt(h)", "white_deg_sqrt_h",  "sigma_deg_h", "sigma_deg_h_sqrt_h"};
const SensorUnits kAccel{"accel",       1e3 / kStandardGravityMps2, "mg",       60.0,
                         "m/s/sqrt(h)", "white_m_s_sqrt_h",         "sigma_mg", "sigma_mg_sqrt_h"};
constexpr double kSqrtSecondsPerHour = 60.0;

struct Axis {
  double mean = 0.0;  // SI
  std::vector<AllanPoint> curve;
  NoiseFit fit;
};

struct Sensor {
  const SensorUnits& units;
  std::vector<Axis> axes;
  std::vector<AllanPoint> mean_curve;
  NoiseFit fit;  // fitted to the mean curve: one model for the three axes
};

std::vector<double> AxisValues(const ImuData& imu, bool gyro, int axis) {
  std::vector<double> values;
  values.reserve(imu.samples.size());
  for (const ImuSample& sample : imu.samples) {
    values.push_back((gyro ? sample.w_ib_b_radps : sample.f_b_mps2)[axis]);
  }
  return values;
}

Sensor Analyse(const ImuData& imu, const SensorUnits& units, bool gyro, Run* run,
               std::vector<std::string>* warnings) {
  Sensor sensor{units, {}, {}, {}};
  std::vector<std::vector<AllanPoint>> curves;
  for (int i = 0; i < 3; ++i) {
    run->progress().Stage("Allan variance", fmt::format("{} {}", units.name, kXyz[i]));
    if (SignalReceived()) throw dn::Interrupted();
    const std::vector<double> values = AxisValues(imu, gyro, i);
    Axis axis;
    axis.mean = MeanRate(values);
    axis.curve = AllanVariance(values, imu.nominal_dt_s);
    axis.fit = FitNoise(axis.curve);
    if (!AtRest(values, imu.nominal_dt_s, gyro ? kRestGyroRadps : kRestAccelMps2)) {
      throw InvalidInput(fmt::format(
          "{} {}: the sensor was not at rest, so the noise terms would include its motion; cut out "
          "a part at rest",
          units.name, kXyz[i]));
    }
    const double drift = DriftInSigmas(values, imu.nominal_dt_s, axis.fit);
    if (std::abs(drift) > kDriftSigmas) {
      warnings->push_back(fmt::format(
          "{} {}: the record drifts from its first to its last third by {:.3g} times the sigma of "
          "its stationary terms, perhaps with temperature; a fitted random walk may be this drift",
          units.name, kXyz[i], std::abs(drift)));
    }
    curves.push_back(axis.curve);
    sensor.axes.push_back(std::move(axis));
  }
  sensor.mean_curve = MeanCurve(curves);
  sensor.fit = FitNoise(sensor.mean_curve);
  return sensor;
}

Json TermJson(const std::optional<NoiseTerm>& term, double unit, const char* name) {
  if (!term) return nullptr;
  return {{"value", unit * term->value}, {"sigma", unit * term->sigma}, {"unit", name}};
}

Json FitJson(const NoiseFit& fit, const SensorUnits& u) {
  const std::string walk_unit = std::string(u.rate_unit) + "/sqrt(h)";
  return {{"white", TermJson(fit.white, u.white_per_si, u.white_unit)},
          {"gauss_markov", TermJson(fit.gauss_markov, u.rate_per_si, u.rate_unit)},
          {"gauss_markov_tau", TermJson(fit.gauss_markov_tau_s, 1.0, "s")},
          {"random_walk",
           TermJson(fit.random_walk, u.rate_per_si * kSqrtSecondsPerHour, walk_unit.c_str())},
          {"floor", {{"deviation", u.rate_per_si * fit.floor}, {"tau_s", fit.floor_tau_s}}},
          {"longest_tau_s", fit.longest_tau_s},
          {"chi2", fit.chi2},
          {"dof", fit.dof}};
}

Json CurveJson(const std::vector<AllanPoint>& curve, const SensorUnits& u) {
  Json tau = Json::array(), deviation = Json::array(), sigma = Json::array();
  for (const AllanPoint& p : curve) {
    tau.push_back(p.tau_s);
    deviation.push_back(u.rate_per_si * p.deviation());
    sigma.push_back(u.rate_per_si * p.sigma_of_deviation());
  }
  return {{"unit", u.rate_unit}, {"tau_s", tau}, {"deviation", deviation}, {"sigma", sigma}};
}

Json SensorJson(const Sensor& sensor) {
  Json json = {{"model", FitJson(sensor.fit, sensor.units)}};
  for (std::size_t i = 0; i < 3; ++i) {
    const Axis& axis = sensor.axes[i];
    json[kXyz[i]] = {{"mean", sensor.units.rate_per_si * axis.mean},
                     {"curve", CurveJson(axis.curve, sensor.units)},
                     {"terms", FitJson(axis.fit, sensor.units)}};
  }
  return json;
}

std::string Csv(const std::vector<Sensor>& sensors) {
  std::string text = "# tau [s]; deviation of";
  for (const Sensor& sensor : sensors) {
    text += fmt::format(" {} x, y, z [{}];", sensor.units.name, sensor.units.rate_unit);
  }
  text += " their sigmas in the same order\n";
  for (std::size_t p = 0; p < sensors[0].axes[0].curve.size(); ++p) {
    text += fmt::format("{}", sensors[0].axes[0].curve[p].tau_s);
    for (const bool sigma : {false, true}) {
      for (const Sensor& sensor : sensors) {
        for (const Axis& axis : sensor.axes) {
          const AllanPoint& point = axis.curve[p];
          text +=
              fmt::format(",{:.8g}", sensor.units.rate_per_si *
                                         (sigma ? point.sigma_of_deviation() : point.deviation()));
        }
      }
    }
    text += "\n";
  }
  return text;
}

std::string Terms(const NoiseFit& fit, const SensorUnits& u) {
  const auto term = [](const std::optional<NoiseTerm>& t, double unit) {
    return t ? fmt::format("{:.3g} +- {:.1g}", unit * t->value, unit * t->sigma) : std::string("-");
  };
  return fmt::format("{:>18} {:>18} {:>16} {:>18} {:>10.3g} at {:.0f} s",
                     term(fit.white, u.white_per_si), term(fit.gauss_markov, u.rate_per_si),
                     term(fit.gauss_markov_tau_s, 1.0),
                     term(fit.random_walk, u.rate_per_si * kSqrtSecondsPerHour),
                     u.rate_per_si * fit.floor, fit.floor_tau_s);
}

void PrintTable(const std::vector<Sensor>& sensors) {
  for (const Sensor& sensor : sensors) {
    const SensorUnits& u = sensor.units;
    fmt::print("{:<6} {:>18} {:>18} {:>16} {:>18} {:>10}\n", u.name,
               fmt::format("white {}", u.white_unit), fmt::format("GM sigma {}", u.rate_unit),
               "GM tau s", fmt::format("walk {}/sqrt(h)", u.rate_unit), "floor");
    for (std::size_t i = 0; i < 3; ++i) {
      fmt::print("  {:<4} {}\n", kXyz[i], Terms(sensor.axes[i].fit, u));
    }
    fmt::print("  {:<4} {}\n", "all", Terms(sensor.fit, u));
  }
}

/// Returns true if the sigma of a term is at most half its value.
bool Determined(const std::optional<NoiseTerm>& term) {
  return term && term->sigma <= 0.5 * term->value;
}

std::string SensorYaml(const Sensor& sensor) {
  const SensorUnits& u = sensor.units;
  const SensorNoise noise = sensor.fit.ToSensorNoise();
  std::string text = fmt::format("  {}:\n", u.name);
  const auto comment = [&](const char* what, const std::optional<NoiseTerm> NoiseFit::*term,
                           double unit) {
    std::string axes;
    for (const Axis& axis : sensor.axes) {
      const std::optional<NoiseTerm>& t = axis.fit.*term;
      axes += t ? fmt::format(" {:.3g}", unit * t->value) : std::string(" -");
    }
    return fmt::format("    # {} by axis:{}\n", what, axes);
  };
  text += comment("white", &NoiseFit::white, u.white_per_si);
  if (noise.white > 0.0) {
    text += fmt::format("    {}: {:.4g}\n", u.white_key, u.white_per_si * noise.white);
  } else {
    text += fmt::format("    # {}: not found; take it from the data sheet\n", u.white_key);
  }
  text += fmt::format(
      "    # means by axis [{}]: {:.4g} {:.4g} {:.4g}; a turn-on bias needs several\n"
      "    # records, or the data sheet: {{type: random_constant, {}: ...}}\n",
      u.rate_unit, u.rate_per_si * sensor.axes[0].mean, u.rate_per_si * sensor.axes[1].mean,
      u.rate_per_si * sensor.axes[2].mean, u.sigma_key);
  text += comment("Gauss-Markov sigma", &NoiseFit::gauss_markov, u.rate_per_si);
  text += comment("Gauss-Markov tau", &NoiseFit::gauss_markov_tau_s, 1.0);
  text += comment("random walk", &NoiseFit::random_walk, u.rate_per_si * kSqrtSecondsPerHour);
  std::string certain, uncertain;
  for (const BiasProcess& process : noise.processes) {
    const bool markov = process.type == BiasProcess::Type::kGaussMarkov;
    const bool determined =
        markov ? Determined(sensor.fit.gauss_markov) && Determined(sensor.fit.gauss_markov_tau_s)
               : Determined(sensor.fit.random_walk);
    const std::string line =
        markov ? fmt::format("{{type: gauss_markov, {}: {:.4g}, tau_s: {:.4g}}}\n", u.sigma_key,
                             u.rate_per_si * process.sigma, process.tau_s)
               : fmt::format("{{type: random_walk, {}: {:.4g}}}\n", u.walk_key,
                             u.rate_per_si * kSqrtSecondsPerHour * process.sigma);
    (determined ? certain : uncertain) += (determined ? "      - " : "      # - ") + line;
  }
  text += certain.empty() ? "    processes: []\n" : "    processes:\n" + certain;
  if (!uncertain.empty()) text += "      # not determined by this record:\n" + uncertain;
  return text;
}

std::string NoiseYaml(const std::vector<Sensor>& sensors, const AllanArguments& options,
                      const ImuData& imu) {
  std::string text = fmt::format(
      "# Noise of {} by Allan variance: {} values at {:.6g} Hz. One model for three axes, fitted "
      "to\n"
      "# the mean of their variances. The record is too short for terms slower than {:.0f} s.\n"
      "imu:\n",
      options.file.filename().string(), imu.samples.size(), 1.0 / imu.nominal_dt_s,
      sensors[0].fit.longest_tau_s);
  for (const Sensor& sensor : sensors) text += SensorYaml(sensor);
  return text;
}

void AddPlot(const Sensor& sensor, Run* run) {
  std::vector<PlotPanel> panels;
  PlotPanel panel{fmt::format("log10 deviation [{}]", sensor.units.rate_unit), {}};
  const auto point = [&](double tau_s, double variance) {
    return std::pair(std::log10(tau_s), std::log10(sensor.units.rate_per_si * std::sqrt(variance)));
  };
  for (std::size_t i = 0; i < 3; ++i) {
    PlotSeries measured{kXyz[i], {}, PlotStyle::kPoints};
    for (const AllanPoint& p : sensor.axes[i].curve) {
      if (p.variance > 0.0) measured.points.push_back(point(p.tau_s, p.variance));
    }
    panel.series.push_back(std::move(measured));
  }
  PlotSeries model{"model", {}};
  for (const AllanPoint& p : sensor.mean_curve) {
    model.points.push_back(point(p.tau_s, sensor.fit.Variance(p.tau_s)));
  }
  panel.series.push_back(std::move(model));
  panels.push_back(std::move(panel));
  const std::string name = sensor.units.name;
  if (const auto svg = DrawSvg("Allan deviation, " + name, "log10 cluster time [s]", panels)) {
    run->AddFile("allan_" + name + ".svg", *svg);
  } else {
    run->progress().Warn("no plots: gnuplot is not installed or failed");
  }
}

/// Returns the gaps and the bridged gaps in the order of time.
std::vector<ImuGap> Holes(const ImuData& imu) {
  std::vector<ImuGap> holes = imu.gaps;
  for (const ImuBridge& bridge : imu.bridges) {
    holes.push_back({bridge.t_begin_s, bridge.row.t_s - bridge.row.dt_s});
  }
  std::sort(holes.begin(), holes.end(),
            [](const ImuGap& a, const ImuGap& b) { return a.t_begin_s < b.t_begin_s; });
  return holes;
}

void CheckRecord(const AllanArguments& options, const ImuData& imu) {
  if (imu.uneven) {
    throw InvalidInput(
        "the rows are not evenly spaced; the Allan variance needs evenly spaced rows",
        {options.file.string()});
  }
  const double found_hz = 1.0 / imu.nominal_dt_s;
  if (std::abs(found_hz / options.rate_hz - 1.0) > kRateTolerance) {
    throw InvalidConfig(fmt::format(
        "--rate {} Hz, but the time tags of {} say {:.6g} Hz; give the rate of the file",
        options.rate_hz, options.file.string(), found_hz));
  }
  const std::vector<ImuGap> holes = Holes(imu);
  if (!holes.empty()) {
    throw InvalidInput(
        fmt::format("{} gaps in the record, the first from {:.3f} to {:.3f} s; the "
                    "Allan variance needs evenly spaced rows: cut out the longest part "
                    "without a gap",
                    holes.size(), holes[0].t_begin_s, holes[0].t_end_s),
        {options.file.string()});
  }
}

void Allan(const AllanArguments& options, Run& run) {
  run.progress().Stage("reading " + options.file.string());
  ImuReadOptions read;
  read.format = options.format == "odyn" ? ImuFormat::kOdyn : ImuFormat::kIncrements;
  if (options.rate_unit == "deg/s") read.rate_unit_radps = kRadPerDeg;
  if (options.force_unit == "g") read.force_unit_mps2 = kStandardGravityMps2;
  read.columns = options.columns;
  if (options.body == "FLU") read.R_imu_to_body.diagonal() << 1.0, -1.0, -1.0;
  const ImuData imu = ReadImu(options.file, read);
  CheckRecord(options, imu);
  std::vector<std::string> warnings;
  std::vector<Sensor> sensors;
  sensors.push_back(Analyse(imu, kGyro, true, &run, &warnings));
  sensors.push_back(Analyse(imu, kAccel, false, &run, &warnings));
  for (const std::string& warning : warnings) run.progress().Warn(warning);
  const Json json = {{"schema", "dn.allan/1"},         {"file", options.file.string()},
                     {"values", imu.samples.size()},   {"rate_hz", 1.0 / imu.nominal_dt_s},
                     {"gyro", SensorJson(sensors[0])}, {"accel", SensorJson(sensors[1])}};
  run.AddFile("allan.json", FormatJson(json));
  run.AddFile("allan.csv", Csv(sensors));
  const std::string yaml = NoiseYaml(sensors, options, imu);
  run.AddFile("noise.yaml", yaml);
  run.AddFile(
      "config.resolved.yaml",
      fmt::format("file: {}\nrate_hz: {}\nformat: {}\nrate_unit: {}\nforce_unit: {}\nbody: {}\n",
                  options.file.string(), options.rate_hz, options.format, options.rate_unit,
                  options.force_unit, options.body));
  for (const Sensor& sensor : sensors) AddPlot(sensor, &run);
  run.report()["warnings"] = warnings;
  run.report()["counts"] = {{"imu epochs", imu.samples.size()},
                            {"imu rows repeated, dropped", imu.repeated_rows_dropped}};
  PrintTable(sensors);
  fmt::print("\n{}", yaml);
}

}  // namespace

void AddAllan(CLI::App* program, Action* action) {
  auto options = std::make_shared<AllanArguments>();
  CLI::App* app = program->add_subcommand(
      "allan", "Fits noise terms for flight.yaml to the Allan variance of a record at rest");
  app->add_option("IMU", options->file,
                  "IMU.txt with time [s], angular rates [rad/s] and specific forces [m/s^2]")
      ->required();
  app->add_option("--rate", options->rate_hz,
                  "Rate of the record [Hz], checked against its time tags")
      ->required()
      ->check(PositiveNumber());
  app->add_option("--format", options->format,
                  "File format, odyn or increments, as imu.format of flight.yaml")
      ->check(AllowedValues({"odyn", "increments"}))
      ->capture_default_str();
  app->add_option("--rate-unit", options->rate_unit,
                  "Unit of the rates, rad/s or deg/s (of increments: rad or deg)")
      ->check(AllowedValues({"rad/s", "deg/s"}))
      ->capture_default_str();
  app->add_option("--force-unit", options->force_unit,
                  "Unit of the forces, m/s^2 or g (of increments: m/s or g s)")
      ->check(AllowedValues({"m/s^2", "g"}))
      ->capture_default_str();
  app->add_option("--columns", options->columns,
                  "Names of the columns of a file with others, as imu.columns of flight.yaml: "
                  "t,fx,fy,fz,wx,wy,wz")
      ->delimiter(',')
      ->check(ColumnName());
  app->add_option("--body", options->body,
                  "Body axes of the file: FRD (forward, right, down) or FLU (forward, left, up)")
      ->check(AllowedValues({"FRD", "FLU"}))
      ->capture_default_str();
  AddCommonOptions(app, &options->common, true);
  app->footer("Example: dn allan static/IMU.txt --rate 200 --out noise");
  app->callback([options, action] {
    *action = [options] {
      options->common.inputs = Inputs{{}, {options->file}};
      return Execute("allan", options->common, [&](Run& run) { Allan(*options, run); });
    };
  });
}

}  // namespace dn::apps
