/// real_data DATA_DIR: computes the results of `dn smooth` for measured flights; its figures are in
/// docs/validation/real-data.md.
#include <dn/diagnosis/solution.h>
#include <dn/error.h>
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace dn::bench {
namespace {

namespace fs = std::filesystem;

/// A smoothed flight.
struct Smoothed {
  Flight flight;
  Solution solution;

  Smoothed(Flight read, const AdjustOptions& options)
      : flight(std::move(read)), solution(flight, options) {}
};

Flight Read(const fs::path& folder) {
  FlightNeeds needs;
  needs.imu = needs.gnss = true;
  return ReadFlight(folder, needs);
}

AdjustOptions InsGnss() {
  AdjustOptions options;
  options.with_pairs = false;
  return options;
}

void PrintSeries(const char* title, const std::vector<SeriesStatistics>& series) {
  fmt::print("{}\n  {:<14} {:<6} {:>6} {:>8} {:>9} {:>9} {:>7} {:>7}\n", title, "sensor", "axis",
             "count", "mean", "variance", "expected", "lag-1", "worst");
  for (const SeriesStatistics& s : series) {
    if (s.sensor.rfind("gnss", 0) != 0) continue;
    fmt::print("  {:<14} {:<6} {:>6} {:>8.3f} {:>9.3f} {:>9.3f} {:>7.3f} {:>7.2f}\n", s.sensor,
               s.axis, s.count, s.mean, s.variance, s.expected_variance, s.lag1_correlation,
               s.worst);
  }
}

void Describe(const std::string& name, const Smoothed& smoothed) {
  const AdjustmentFigures& figures = smoothed.solution.trajectory().figures;
  fmt::print(
      "\n== {}: {} nodes, {} inertial and {} GNSS epochs, {} rejected, start by {}\n"
      "sigma0 {:.3f}, redundancy {}, NIS / 3 of position {:.2f}, of velocity {:.2f}\n",
      name, figures.nodes, figures.imu_epochs, figures.gnss_epochs,
      smoothed.solution.adjustment().gnss_rejected.size(),
      smoothed.solution.adjustment().alignment_method, figures.sigma0, figures.redundancy,
      smoothed.solution.trajectory().nis_position, smoothed.solution.trajectory().nis_velocity);
  PrintSeries("innovations", smoothed.solution.trajectory().innovations);
  PrintSeries("residuals", smoothed.solution.trajectory().residuals);
}

/// Accumulates the root mean square of vectors, component by component.
class Rms {
 public:
  void Add(const Eigen::Vector3d& x) {
    sum_ += x;
    sum2_ += x.cwiseAbs2();
    ++n_;
  }
  Eigen::Vector3d mean() const { return sum_ / static_cast<double>(n_); }
  Eigen::Vector3d rms() const { return (sum2_ / static_cast<double>(n_)).cwiseSqrt(); }
  long count() const { return n_; }

 private:
  Eigen::Vector3d sum_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d sum2_ = Eigen::Vector3d::Zero();
  long n_ = 0;
};

void CompareWithReference(const Smoothed& smoothed) {
  const FlightNetwork& network = smoothed.solution.network();
  const std::vector<MapPose> reference =
      smoothed.flight.reference->ToMapPoses(smoothed.flight.frame);
  const auto each_node = [&](const std::function<void(const MapPose&, const MapPose&)>& use) {
    for (std::size_t k = 0; k < network.nodes().size(); ++k) {
      const MapPose estimate = network.trajectory().NodePose(k);
      if (smoothed.flight.reference->Covers(estimate.t_s)) {
        use(estimate, InterpolatePose(reference, estimate.t_s));
      }
    }
  };
  Rms turned, velocity;
  each_node([&](const MapPose& estimate, const MapPose& truth) {
    turned.Add(Log(Eigen::Quaterniond(estimate.q_mb.conjugate() * truth.q_mb)));
    velocity.Add(estimate.v_m - truth.v_m);
  });
  const Eigen::Quaterniond constant = Exp(turned.mean());
  Rms remaining;
  each_node([&](const MapPose& estimate, const MapPose& truth) {
    remaining.Add(Log(Eigen::Quaterniond((estimate.q_mb * constant).conjugate() * truth.q_mb)));
  });
  const Eigen::Vector3d c = turned.mean() * kDegPerRad, r = remaining.rms() * kDegPerRad,
                        v = velocity.rms();
  double sigma2_rp = 0.0, sigma2_h = 0.0;
  for (const TrajectorySigma& sigma : smoothed.solution.trajectory().sigma) {
    sigma2_rp += sigma.rph_rad.head<2>().squaredNorm() / 2.0;
    sigma2_h += sigma.rph_rad.z() * sigma.rph_rad.z();
  }
  const auto n = static_cast<double>(smoothed.solution.trajectory().sigma.size());
  fmt::print(
      "against the reference at {} nodes: constant turn of the axes {:.3f} {:.3f} {:.3f} deg (body "
      "x, y, z), remaining rms {:.3f} {:.3f} {:.3f} deg; velocity rms {:.4f} {:.4f} {:.4f} m/s\n"
      "own sigma: roll, pitch {:.3f} deg, heading {:.3f} deg\n",
      remaining.count(), c[0], c[1], c[2], r[0], r[1], r[2], v[0], v[1], v[2],
      std::sqrt(sigma2_rp / n) * kDegPerRad, std::sqrt(sigma2_h / n) * kDegPerRad);
}

void SmoothAndDescribe(const fs::path& data, const std::string& name) {
  const Smoothed smoothed(Read(data / name), InsGnss());
  Describe(name, smoothed);
  if (name == "psins-car") CompareWithReference(smoothed);
}

void Run(const fs::path& data) {
  for (const char* name : {"thor75", "walk", "psins-car"}) {
    try {
      SmoothAndDescribe(data, name);
    } catch (const InvalidInput& error) {
      fmt::print("{}: refused: {}\n", name, error.what());
    }
  }
}

}  // namespace
}  // namespace dn::bench

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: real_data DATA_DIR   (the folder with thor75, walk, psins-car)\n");
    return 2;
  }
  try {
    dn::bench::Run(argv[1]);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "real_data: error: {}\n", error.what());
    return 1;
  }
}
