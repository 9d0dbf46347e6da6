#include <dn/distributions.h>
#include <dn/fleet/fleet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <utility>
#include <vector>

namespace dn::fleet_test {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;
using ::testing::HasSubstr;

constexpr Index kSensor = 2, kTrack = 6, kUnknowns = 3 + kSensor + 1 + kTrack, kReduced = 6;
constexpr Index kRows = 40;
constexpr double kBoresightRad = 1e-4, kTrackM = 0.02, kNoiseM = 0.01, kReturnM = 1e-3;

/// Prior standard deviations of two effects of the sensor and of a clock.
VectorXd PriorSigma() {
  VectorXd sigma(kSensor + 1);
  sigma << 2e-4, 0.01, 1e-4;
  return sigma;
}

/// Linear flights y = D x + noise of variance 1, x = [b; effects of the sensor; clock; track]. The
/// ground points of a flight lie at base + G (x - truth), and two flights share some of them.
class TiedFleet {
 public:
  TiedFleet(std::size_t count, Index points, std::uint64_t seed) : generator_(seed) {
    const VectorXd sensor = Draw(kSensor).cwiseProduct(PriorSigma().head(kSensor));
    for (std::size_t k = 0; k < count; ++k) Fly(sensor, 2 * points);
    for (std::size_t k = 0; k + 1 < count; ++k) {
      for (Index p = 0; p < points; ++p) ties_.push_back({k, k + 1, points + p, p, Noise()});
    }
  }

  std::vector<ReducedFlight> Reduce() const {
    std::vector<ReducedFlight> flights;
    for (std::size_t k = 0; k < flown_.size(); ++k) flights.push_back(ReduceOne(k));
    for (std::size_t t = 0; t < ties_.size(); ++t) {
      const OneTie& tie = ties_[t];
      const std::string name = "between/" + std::to_string(tie.i) + "_" + std::to_string(tie.j) +
                               ".txt:" + std::to_string(t + 1);
      flights[tie.i].ties->names[static_cast<std::size_t>(tie.at_i)] = name;
      flights[tie.j].ties->names[static_cast<std::size_t>(tie.at_j)] = name;
      flights[tie.i].ties->noise_m2[static_cast<std::size_t>(tie.at_i)] =
          kNoiseM * kNoiseM * Matrix3d::Identity();
      // The noise of the pair moves its first end.
      flights[tie.i].ties->moments.mean_e_m.segment<3>(3 * tie.at_i) += tie.noise_m;
      flights[tie.i].ties->as_modelled.mean_e_m.segment<3>(3 * tie.at_i) += tie.noise_m;
    }
    return flights;
  }

  /// Returns boresight and covariance of one adjustment with all unknowns of all flights.
  std::pair<Vector3d, Matrix3d> AdjustJointly() const {
    const auto count = static_cast<Index>(flown_.size());
    const Index own = 1 + kTrack, common = 3 + kSensor, n = common + count * own;
    MatrixXd N = MatrixXd::Zero(n, n);
    VectorXd g = VectorXd::Zero(n);
    N.diagonal().segment(3, kSensor) += PriorSigma().head(kSensor).cwiseAbs2().cwiseInverse();
    const auto spread = [&](const MatrixXd& A, std::size_t k) {
      MatrixXd all = MatrixXd::Zero(A.rows(), n);
      all.leftCols(common) = A.leftCols(common);
      all.middleCols(common + static_cast<Index>(k) * own, own) = A.rightCols(own);
      return all;
    };
    for (std::size_t k = 0; k < flown_.size(); ++k) {
      const MatrixXd A = spread(flown_[k].D, k);
      N += A.transpose() * A;
      g += A.transpose() * flown_[k].y;
      const Index clock = common + static_cast<Index>(k) * own;
      N(clock, clock) += 1.0 / std::pow(PriorSigma()[kSensor], 2);
    }
    for (const OneTie& tie : ties_) {
      const Flown &a = flown_[tie.i], &b = flown_[tie.j];
      const MatrixXd G_i = a.G.middleRows<3>(3 * tie.at_i), G_j = b.G.middleRows<3>(3 * tie.at_j);
      const MatrixXd A = spread(G_i, tie.i) - spread(G_j, tie.j);
      const Vector3d z = G_i * a.truth - G_j * b.truth - tie.noise_m;
      const double weight = 1.0 / (kNoiseM * kNoiseM + 2.0 * kReturnM * kReturnM);
      N += weight * A.transpose() * A;
      g += weight * A.transpose() * z;
    }
    const Eigen::LLT<MatrixXd> llt(N);
    const MatrixXd C = llt.solve(MatrixXd::Identity(n, n));
    return {llt.solve(g).head<3>(), C.topLeftCorner<3, 3>()};
  }

  void MoveFirstEnd(std::size_t tie, const Vector3d& by_m) { ties_[tie].noise_m += by_m; }

 private:
  struct Flown {
    MatrixXd D, G;
    VectorXd y, truth;
  };
  struct OneTie {
    std::size_t i, j;
    Index at_i, at_j;
    Vector3d noise_m;
  };

  VectorXd Draw(Index size) {
    return VectorXd::NullaryExpr(size, [this] { return normal_(generator_); });
  }
  MatrixXd Draw(Index rows, Index columns) {
    return MatrixXd::NullaryExpr(rows, columns, [this] { return normal_(generator_); });
  }
  Vector3d Noise() { return kNoiseM * Draw(3); }

  /// Flies with the boresight 0. The data hardly separate the effects from the boresight.
  void Fly(const VectorXd& sensor, Index points) {
    Flown flown;
    VectorXd unit(kUnknowns);
    unit << VectorXd::Constant(3, kBoresightRad), PriorSigma(), VectorXd::Constant(kTrack, kTrackM);
    flown.D = Draw(kRows, kUnknowns) / std::sqrt(static_cast<double>(kRows));
    const MatrixXd alike = flown.D.leftCols<3>() * Draw(3, kSensor + 1);
    flown.D.middleCols(3, kSensor + 1) = alike + 0.1 * flown.D.middleCols(3, kSensor + 1);
    flown.D = (flown.D * unit.cwiseInverse().asDiagonal()).eval();
    flown.G = Draw(3 * points, kUnknowns) * (kTrackM * unit.cwiseInverse()).asDiagonal();
    flown.truth.resize(kUnknowns);
    flown.truth << VectorXd::Zero(3), sensor, PriorSigma()[kSensor] * Draw(1),
        kTrackM * Draw(kTrack);
    flown.y = flown.D * flown.truth + Draw(kRows);
    flown_.push_back(std::move(flown));
  }

  ReducedFlight ReduceOne(std::size_t k) const {
    const Flown& flown = flown_[k];
    ReducedFlight flight;
    flight.name = "flight " + std::to_string(k + 1);
    MatrixXd N = flown.D.transpose() * flown.D;
    N.diagonal().segment(3, kSensor + 1) += PriorSigma().cwiseAbs2().cwiseInverse();
    const MatrixXd C = N.llt().solve(MatrixXd::Identity(kUnknowns, kUnknowns));
    const VectorXd x = C * flown.D.transpose() * flown.y;
    flight.mean = x.head(kReduced);
    flight.covariance = C.topLeftCorner(kReduced, kReduced);
    flight.effects = {{EffectId::kLidarScanCone, false, {0}, PriorSigma().head(1)},
                      {EffectId::kLidarRangeOffset, false, {0}, PriorSigma().segment(1, 1)},
                      {EffectId::kLidarTimeOffset, false, {0}, PriorSigma().tail(1)}};
    flight.ties.emplace();
    flight.ties->moments = Points(flown, x, C, kReduced);
    const Index points = flown.G.rows() / 3;
    flight.ties->names.assign(static_cast<std::size_t>(points), "alone " + flight.name);
    flight.ties->noise_m2.resize(static_cast<std::size_t>(points));
    // The pure model has no effects.
    std::vector<Index> own{0, 1, 2};
    for (Index i = kReduced; i < kUnknowns; ++i) own.push_back(i);
    const MatrixXd D = flown.D(Eigen::all, own);
    MatrixXd pure_C = MatrixXd::Zero(kUnknowns, kUnknowns);
    const MatrixXd inverse = (D.transpose() * D).inverse();
    pure_C(own, own) = inverse;
    const VectorXd pure = pure_C * flown.D.transpose() * flown.y;
    flight.as_modelled = {pure.head<3>(), pure_C.topLeftCorner<3, 3>()};
    flight.ties->as_modelled = Points(flown, pure, pure_C, 3);
    return flight;
  }

  static TieMoments Points(const Flown& flown, const VectorXd& x, const MatrixXd& C, Index cross) {
    TieMoments moments{flown.G * (x - flown.truth), flown.G * C * flown.G.transpose(),
                       flown.G * C.leftCols(cross)};
    moments.mean_e_m.array() += 4e6;
    moments.covariance_m2.diagonal().array() += kReturnM * kReturnM;
    return moments;
  }

  std::mt19937_64 generator_;
  std::normal_distribution<double> normal_;
  std::vector<Flown> flown_;
  std::vector<OneTie> ties_;
};

TEST(FleetTies, GiveTheResultOfOneAdjustmentOfAllFlights) {
  const TiedFleet fleet(3, 20, 7);
  const FleetResult result = AdjustFleet(fleet.Reduce(), {});
  ASSERT_TRUE(result.ties);
  EXPECT_EQ(result.ties->used(), 40);
  EXPECT_EQ(result.ties->noise_factor, 1.0);
  const auto [angles, covariance] = fleet.AdjustJointly();
  const Vector3d sigma = covariance.diagonal().cwiseSqrt();
  // The noise of the positions is kept in four nanometres of 4000 km.
  EXPECT_LT((result.boresight.angles_rad - angles).cwiseQuotient(sigma).cwiseAbs().maxCoeff(),
            1e-3);
  EXPECT_LT((result.boresight.sigma_rad() - sigma).cwiseQuotient(sigma).cwiseAbs().maxCoeff(),
            1e-4);
}

TEST(FleetTies, MakeTheBoresightBetter) {
  const TiedFleet fleet(2, 30, 11);
  std::vector<ReducedFlight> flights = fleet.Reduce();
  const FleetResult with = AdjustFleet(flights, {});
  for (ReducedFlight& flight : flights) flight.ties.reset();
  const FleetResult without = AdjustFleet(flights, {});
  EXPECT_FALSE(without.ties);
  EXPECT_TRUE(
      (with.boresight.sigma_rad().array() < 0.9 * without.boresight.sigma_rad().array()).all());
  EXPECT_TRUE((with.boresight.as_modelled->covariance_rad2.diagonal().array() <
               without.boresight.as_modelled->covariance_rad2.diagonal().array())
                  .all());
}

TEST(FleetTies, HaveHonestCovariances) {
  constexpr int kFleets = 300;
  double nees = 0.0;
  for (std::uint64_t seed = 1; seed <= kFleets; ++seed) {
    const FleetResult result = AdjustFleet(TiedFleet(2, 20, seed).Reduce(), {});
    const Vector3d angles = result.boresight.angles_rad;
    nees += angles.dot(result.boresight.covariance_rad2.llt().solve(angles)) / 3.0 / kFleets;
  }
  const auto [low, high] = ChiSquareInterval(0.99, 3.0 * kFleets);
  EXPECT_GT(nees, low);
  EXPECT_LT(nees, high);
}

TEST(FleetTies, LeaveOutWrongPairs) {
  TiedFleet fleet(2, 40, 3);
  fleet.MoveFirstEnd(5, {0.0, 0.2, 0.0});
  fleet.MoveFirstEnd(21, {-0.4, 0.0, 0.3});
  const FleetResult result = AdjustFleet(fleet.Reduce(), {});
  ASSERT_EQ(result.ties->by_strips.size(), 1u);
  EXPECT_EQ(result.ties->by_strips[0].used, 38);
  EXPECT_EQ(result.ties->by_strips[0].rejected, 2);
  EXPECT_EQ(result.ties->Contradiction(), nullptr);
  EXPECT_EQ(result.boresight.verdict, Verdict::kCalibrated);
}

TEST(FleetTies, GroundThatIsApartContradicts) {
  TiedFleet fleet(2, 40, 3);
  for (std::size_t k = 0; k < 40; ++k) fleet.MoveFirstEnd(k, {0.5, 0.0, -0.5});
  const FleetResult result = AdjustFleet(fleet.Reduce(), {});
  ASSERT_NE(result.ties->Contradiction(), nullptr);
  EXPECT_EQ(result.boresight.verdict, Verdict::kContradicted);
  EXPECT_THAT(FleetReasons(result).front(),
              HasSubstr("flights flight 1 and flight 2 see the same"));
}

TEST(FleetTies, AreTheSameAfterWritingAndReading) {
  const std::vector<ReducedFlight> flights = TiedFleet(2, 5, 9).Reduce();
  std::vector<ReducedFlight> read;
  for (const ReducedFlight& flight : flights) {
    const Json json = Json::parse(FormatJson(ReducedFlightJson(flight)));
    read.push_back(ReadReducedFlight(JsonPlace(json, "reduced.json")));
  }
  EXPECT_EQ(read[0].ties->names, flights[0].ties->names);
  const FleetResult one = AdjustFleet(flights, {}), two = AdjustFleet(read, {});
  const Vector3d sigma = one.boresight.sigma_rad();
  EXPECT_LT((one.boresight.angles_rad - two.boresight.angles_rad).cwiseQuotient(sigma).norm(),
            1e-4);
  EXPECT_LT((sigma - two.boresight.sigma_rad()).cwiseQuotient(sigma).norm(), 1e-5);
}

TEST(FleetTies, BadOnesGetAClearError) {
  const Json good = ReducedFlightJson(TiedFleet(2, 5, 9).Reduce()[0]);
  Json fewer = good;
  fewer["ties"]["noise_m2"].erase(0);
  Json indefinite = good;
  indefinite["ties"]["moments"]["covariance_rows_up_to_diagonal"][0][0] = -1.0;
  for (const Json& bad : {fewer, indefinite}) {
    EXPECT_THROW(ReadReducedFlight(JsonPlace(bad, "reduced.json")), InvalidInput);
  }
}

}  // namespace
}  // namespace dn::fleet_test
