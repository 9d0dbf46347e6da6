// Real flights outside this project; the tests are skipped if they are absent.
#include <dn/adjustment/adjust.h>
#include <dn/files/flight.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace dn::adjustment_test {

namespace fs = std::filesystem;

// The GNSS messages of this drone have a delay of a quarter of a second, and its inertial noise is
// a guess. No clock steps.
TEST(RealFlightsManyRuns, ADelayOfGnssMessagesIsNoStepOfAClock) {
  const fs::path folder = fs::path(DN_SHARED_DATA_DIR) / "data/inertialnav-testlog2";
  if (!fs::exists(folder)) GTEST_SKIP() << "no real data in " << folder;
  for (const char* span : {"[100, 400]", "[250, 620]"}) {
    SCOPED_TRACE(span);
    const FlightConfig config = ReadFlightConfig(folder, {std::string("time_span_s=") + span});
    const Flight flight = ReadFlight(config, {.imu = true, .gnss = true});
    AdjustOptions options;
    options.with_pairs = false;
    const Adjustment adjustment = Adjust(flight, options);
    ASSERT_TRUE(adjustment.gnss_clock);
    EXPECT_NEAR(adjustment.gnss_clock->offset_s + 150.0 * adjustment.gnss_clock->drift, 0.25, 0.15);
  }
}

}  // namespace dn::adjustment_test
