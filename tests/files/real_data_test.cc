// Real flight folders outside this project; the tests are skipped if they are absent.
#include <dn/files/flight.h>
#include <dn/imu/noise_check.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dn::files_test {

namespace fs = std::filesystem;

class RealData : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(Folder("."))) GTEST_SKIP() << "no real data in " << Folder(".");
  }
  static fs::path Folder(const std::string& name) {
    return fs::path(DN_SHARED_DATA_DIR) / "data" / name;
  }
  static void ExpectRoundTrip(const FlightConfig& config) {
    const std::string text = FormatFlightConfig(config);
    EXPECT_EQ(FormatFlightConfig(ParseFlightConfig(text, config.folder)), text);
  }
};

constexpr FlightNeeds kSmooth{.imu = true, .gnss = true};

TEST_F(RealData, Thor75) {
  const Flight flight = ReadFlight(Folder("thor75"), kSmooth);
  EXPECT_NEAR(flight.imu->nominal_dt_s, 0.02, 1e-4);
  EXPECT_GE(flight.gnss->epochs.size(), 550u);  // 577 s at 1 Hz
  EXPECT_TRUE(flight.reference);
  EXPECT_GT(flight.counts.at("gnss rows outside time span"), 0);
  ExpectRoundTrip(flight.config);
}

TEST_F(RealData, Walk) {
  const Flight flight = ReadFlight(Folder("walk"), kSmooth);
  EXPECT_GE(flight.gnss->epochs.size(), 500u);  // 132 s at 4 Hz
  EXPECT_TRUE(flight.gnss->epochs.front().velocity_enu_mps);
  EXPECT_FALSE(flight.reference);
  ExpectRoundTrip(flight.config);
}

TEST_F(RealData, PsinsCar) {
  const Flight flight = ReadFlight(Folder("psins-car"), kSmooth);
  EXPECT_NEAR(flight.imu->nominal_dt_s, 0.01, 1e-6);
  EXPECT_GE(flight.gnss->epochs.size(), 99u);
  EXPECT_TRUE(flight.reference);
  ExpectRoundTrip(flight.config);
}

// Engines, hands and roads cause more vibration than the noise of a sensor, more at low
// frequencies, and not equally at all times. White noise of any size therefore does not describe
// the data.
TEST_F(RealData, InertialNoiseIsNotWhite) {
  for (const char* name : {"thor75", "walk", "psins-car"}) {
    SCOPED_TRACE(name);
    const Flight flight = ReadFlight(Folder(name), {.imu = true});
    HighBandOptions options;
    options.sampling = flight.config.imu->read.sampling;
    const NoiseCheck check =
        CheckNoise(MeasureHighBand(*flight.imu, flight.config.imu->model, options));
    for (const ImuTriad triad : {kGyroTriad, kAccelTriad}) {
      ASSERT_TRUE(check.level[triad]);
      EXPECT_GT(check.level[triad]->ratio, 3.0);
      EXPECT_LT(check.level[triad]->tilt, -0.2);
    }
    EXPECT_EQ(BestHypothesis(check.evidence), NoiseHypothesis::kNotWhite);
  }
}

TEST_F(RealData, LiborCheck) {
  const Flight flight = ReadFlight(Folder("libor-check"), {.pairs = true, .trajectory = true});
  EXPECT_EQ(flight.pairs->pairs.size(), 3000u);
  EXPECT_EQ(flight.pairs->files.size(), 3u);
  EXPECT_EQ(FindStrips(flight).size(), 3u);
  EXPECT_FALSE(flight.config.gh.exponential);
  ExpectRoundTrip(flight.config);
}

TEST_F(RealData, TentHasNoPairsYet) {
  const FlightConfig config = ReadFlightConfig(Folder("tent"));
  EXPECT_EQ(config.strips.size(), 2u);
  EXPECT_TRUE(config.lidar->boresight_sigma_rad);
  EXPECT_TRUE(ReadFlight(config, {.trajectory = true}).trajectory);
  EXPECT_THROW(ReadFlight(config, {.pairs = true}), InvalidInput);
  ExpectRoundTrip(config);
}

}  // namespace dn::files_test
