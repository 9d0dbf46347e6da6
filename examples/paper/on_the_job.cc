#include "on_the_job.h"

#include <dn/axis_names.h>
#include <dn/diagnosis/solution.h>
#include <dn/distributions.h>
#include <dn/median.h>
#include <fmt/format.h>

#include <algorithm>
#include <functional>

#include "fly.h"
#include "published.h"

namespace paper {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

double Nees(const Vector3d& error_deg, const Matrix3d& covariance_rad2) {
  const Vector3d error_rad = dn::kRadPerDeg * error_deg;
  return error_rad.dot(covariance_rad2.ldlt().solve(error_rad));
}

Calibrated::Method Judge(const dn::BoresightResult& result, const Vector3d& truth_rad) {
  Calibrated::Method method;
  method.error_deg = ErrorDeg(result.angles_rad, truth_rad);
  method.sigma_deg = dn::kDegPerRad * result.sigma_rad();
  method.nees = Nees(method.error_deg, result.covariance_rad2);
  method.correlation = result.correlation();
  return method;
}

using Vector = std::function<Vector3d(const Calibrated&)>;
using Scalar = std::function<double(const Calibrated&)>;

Vector3d Mean(const SetResult& set, const Vector& value) {
  Vector3d sum = Vector3d::Zero();
  for (const Calibrated& flight : set.flights) sum += value(flight);
  return sum / static_cast<double>(set.flights.size());
}

Vector3d Rms(const SetResult& set, const Vector& value) {
  return Mean(set, [&](const Calibrated& f) -> Vector3d { return value(f).cwiseAbs2(); })
      .cwiseSqrt();
}

double Mean(const SetResult& set, const Scalar& value) {
  double sum = 0.0;
  for (const Calibrated& flight : set.flights) sum += value(flight);
  return sum / static_cast<double>(set.flights.size());
}

double Median(const SetResult& set, const Scalar& value) {
  std::vector<double> values;
  for (const Calibrated& flight : set.flights) values.push_back(value(flight));
  return dn::Median(std::move(values));
}

std::string MilliDegrees(const Vector3d& deg) {
  return fmt::format("{:7.2f} {:7.2f} {:7.2f}", 1e3 * deg.x(), 1e3 * deg.y(), 1e3 * deg.z());
}

std::string Percent(const Matrix3d& m, int row) {
  return fmt::format("{:5.0f} {:5.0f} {:5.0f}", 100.0 * m(row, 0), 100.0 * m(row, 1),
                     100.0 * m(row, 2));
}

}  // namespace

Calibrated Calibrate(const std::string& set, std::uint64_t seed,
                     const std::filesystem::path& folder, std::optional<double> node_rate_hz) {
  SmoothedFlight flight = Fly(dn::ReadScenario(set), seed, folder);
  flight.sim.flight.config.network.node_rate_hz = node_rate_hz;
  dn::GaussHelmertCalibration gh = dn::CalibrateGaussHelmert(flight.sim.flight);
  dn::AssessModel(flight.sim.flight, &gh);
  const dn::BoresightResult network = dn::Solution(flight.sim.flight).Boresight();

  Calibrated out;
  out.rph_rmse_deg = flight.rph_rmse_deg;
  out.gh = Judge(gh.boresight, flight.sim.boresight_rad);
  out.gh.correlation = gh.adjustment.correlation();
  out.dn = Judge(network, flight.sim.boresight_rad);
  out.gh_sigma_formal_deg = dn::kDegPerRad * *gh.boresight.sigma_scaled_rad;
  out.condition_number = gh.adjustment.condition_number;
  out.sigma0 = gh.adjustment.sigma0;
  out.residual_initial_m = gh.adjustment.residual_initial_m;
  out.residual_final_m = gh.adjustment.residual_final_m;
  out.dn_accel = network.accel_bias.at_barycentre;
  out.dn_gyro = network.gyro_bias.at_barycentre;
  out.gh_verdict = gh.boresight.verdict;
  out.dn_verdict = network.verdict;
  return out;
}

void PrintAttitude(const std::vector<SetResult>& sets) {
  fmt::print("\nRMSE of the smoothed attitude [deg], roll and pitch, heading\n");
  fmt::print("{:<10} {:>19} {:>19}\n", "", "simulated", "paper, Table 1");
  for (const SetResult& set : sets) {
    const Vector3d rms = Rms(set, [](const Calibrated& f) { return f.rph_rmse_deg; });
    const PublishedSet& published = Published(set.name);
    fmt::print("{:<10} {:>9.4f} {:>9.4f} {:>9.4f} {:>9.4f}\n", set.name,
               rms.head<2>().norm() / std::sqrt(2.0), rms.z(), published.sigma_rp_deg,
               published.sigma_y_deg);
  }
}

void PrintAdjustment(const std::vector<SetResult>& sets) {
  fmt::print(
      "\nGauss-Helmert adjustment: condition number, sigma0, mean residual before and after [m]\n");
  fmt::print("{:<10} {:>31} {:>31}\n", "", "simulated (median)", "paper");
  for (const SetResult& set : sets) {
    const PublishedSet& p = Published(set.name);
    fmt::print("{:<10} {:>9.0f} {:>6.2f} {:>7.2f} {:>6.2f} {:>9.0f} {:>6.1f} {:>7.2f} {:>6.2f}\n",
               set.name, Median(set, [](const Calibrated& f) { return f.condition_number; }),
               Median(set, [](const Calibrated& f) { return f.sigma0; }),
               Median(set, [](const Calibrated& f) { return f.residual_initial_m; }),
               Median(set, [](const Calibrated& f) { return f.residual_final_m; }),
               p.condition_number, p.sigma0, p.residual_initial_m, p.residual_final_m);
  }
}

void PrintErrors(const std::vector<SetResult>& sets) {
  fmt::print("\nBoresight roll, pitch, yaw against the truth [mdeg]\n");
  fmt::print("{:<10} {:>23} {:>25} {:>25} {:>25}\n", "", "GH rms error", "GH mean error",
             "DN rms error", "GH - DN rms");
  for (const SetResult& set : sets) {
    fmt::print("{:<10} {} | {} | {} | {}\n", set.name,
               MilliDegrees(Rms(set, [](const Calibrated& f) { return f.gh.error_deg; })),
               MilliDegrees(Mean(set, [](const Calibrated& f) { return f.gh.error_deg; })),
               MilliDegrees(Rms(set, [](const Calibrated& f) { return f.dn.error_deg; })),
               MilliDegrees(Rms(set, [](const Calibrated& f) -> Vector3d {
                 return f.gh.error_deg - f.dn.error_deg;
               })));
  }
  fmt::print("\nStandard deviations, mean over the flights [mdeg]\n");
  fmt::print("{:<10} {:>23} {:>25} {:>25}\n", "", "GH formal (x sigma0)", "GH honest", "DN");
  for (const SetResult& set : sets) {
    fmt::print("{:<10} {} | {} | {}\n", set.name,
               MilliDegrees(Mean(set, [](const Calibrated& f) { return f.gh_sigma_formal_deg; })),
               MilliDegrees(Mean(set, [](const Calibrated& f) { return f.gh.sigma_deg; })),
               MilliDegrees(Mean(set, [](const Calibrated& f) { return f.dn.sigma_deg; })));
  }
}

void PrintConsistency(const std::vector<SetResult>& sets) {
  constexpr double kProbability = 0.99;
  fmt::print(
      "\nHonesty of the standard deviations: rms of error / GH formal sigma; honest sigma / rms\n"
      "error (largest of the angles); mean NEES / 3 with its 99 % interval; GH verdicts\n");
  fmt::print("{:<10} {:>20} {:>8} {:>8} {:>8} {:>14}\n", "", "error/formal r p y", "honest",
             "NEES GH", "NEES DN", "interval");
  for (const SetResult& set : sets) {
    const Vector3d formal = Rms(set, [](const Calibrated& f) -> Vector3d {
      return f.gh.error_deg.cwiseQuotient(f.gh_sigma_formal_deg);
    });
    const Vector3d width =
        Rms(set, [](const Calibrated& f) {
          return f.gh.sigma_deg;
        }).cwiseQuotient(Rms(set, [](const Calibrated& f) { return f.gh.error_deg; }));
    const dn::Interval interval =
        dn::ChiSquareInterval(kProbability, 3.0 * static_cast<double>(set.flights.size()));
    const auto calibrated =
        std::count_if(set.flights.begin(), set.flights.end(),
                      [](const Calibrated& f) { return f.gh_verdict == dn::Verdict::kCalibrated; });
    fmt::print(
        "{:<10} {:>6.1f} {:>6.1f} {:>6.1f} {:>8.2f} {:>8.2f} {:>8.2f} {:>6.2f}..{:.2f}  "
        "{} of {} calibrated\n",
        set.name, formal.x(), formal.y(), formal.z(), width.maxCoeff(),
        Mean(set, [](const Calibrated& f) { return f.gh.nees / 3.0; }),
        Mean(set, [](const Calibrated& f) { return f.dn.nees / 3.0; }), interval.low, interval.high,
        calibrated, set.flights.size());
  }
}

void PrintCorrelations(const std::vector<SetResult>& sets) {
  fmt::print(
      "\nCorrelations of the first flight [%]; rows and columns roll, pitch, yaw; biases x, "
      "y, z at the lidar barycentre\n");
  fmt::print("{:<16} {:>17}   {:>17}   {:>17}   {:>17}\n", "", "GH", "DN", "DN accel bias",
             "DN gyro bias");
  for (const SetResult& set : sets) {
    const Calibrated& flight = set.flights.front();
    for (int row = 0; row < 3; ++row) {
      fmt::print("{:<10}{:<6} {}   {}   {}   {}\n", row == 0 ? set.name : "",
                 dn::kRollPitchYaw[row], Percent(flight.gh.correlation, row),
                 Percent(flight.dn.correlation, row), Percent(flight.dn_accel, row),
                 Percent(flight.dn_gyro, row));
    }
  }
}

}  // namespace paper
