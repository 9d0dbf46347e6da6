#include <dn/gnss/gnss_data.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <string>

#include "testing/expect_invalid.h"
#include "testing/temp_file.h"

namespace dn::gnss_test {

using testing::ExpectInvalid;
using testing::TempFile;

GnssData ReadNmea(const std::string& text) {
  const TempFile file("GPS.nmea", text);
  return ReadGnss(file.path(), GnssFormat::kNmea);
}

/// Returns the sentence with '$' and checksum.
std::string Sentence(const std::string& text) {
  unsigned sum = 0;
  for (const char c : text) sum ^= static_cast<unsigned char>(c);
  char end[8];
  std::snprintf(end, sizeof end, "*%02X\r\n", sum);
  return "$" + text + end;
}

std::string Gga(const std::string& time, const std::string& fix = "1") {
  return Sentence("GPGGA," + time + ",4807.038,N,01131.000,W," + fix + ",08,0.9,545.4,M,46.9,M,,");
}

std::string Rmc(const std::string& time, const std::string& date) {
  return Sentence("GPRMC," + time + ",A,4807.038,N,01131.000,W,022.4,084.4," + date + ",003.1,W");
}

// This sentence appears in most descriptions of the format; its date is a Wednesday with 9 leap
// seconds.
TEST(Nmea, ReadsAPosition) {
  const GnssData data = ReadNmea(
      "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\n"
      "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\n");
  ASSERT_EQ(data.epochs.size(), 1u);
  const GnssEpoch& epoch = data.epochs[0];
  EXPECT_EQ(epoch.t_s, 3 * 86400 + 12 * 3600 + 35 * 60 + 19 + 9);
  EXPECT_NEAR(epoch.antenna.lat_rad * kDegPerRad, 48.0 + 7.038 / 60.0, 1e-12);
  EXPECT_NEAR(epoch.antenna.lon_rad * kDegPerRad, 11.0 + 31.0 / 60.0, 1e-12);
  EXPECT_NEAR(epoch.antenna.h_m, 545.4 + 46.9, 1e-9);
  EXPECT_FALSE(epoch.covariance_enu_m2 || epoch.velocity_enu_mps);
}

// Midnight from Saturday to Sunday is also the end of a GPS week.
TEST(Nmea, CrossesMidnightAndTheEndOfAWeek) {
  const GnssData data = ReadNmea(Gga("235930.00") + Gga("235959.50") + Rmc("235959.50", "220625") +
                                 Gga("000000.50") + Gga("000001.50"));
  ASSERT_EQ(data.epochs.size(), 4u);
  EXPECT_LT(data.epochs[0].antenna.lon_rad, 0.0);
  EXPECT_EQ(data.epochs[0].t_s, 86400 - 30 + 18);  // 22 June 2025 is a Sunday
  EXPECT_EQ(data.epochs[2].t_s - data.epochs[1].t_s, 1.0);
  const GnssData week = ReadNmea(Rmc("235940", "210625") + Gga("235940") + Gga("235943"));
  EXPECT_EQ(week.epochs[1].t_s - week.epochs[0].t_s, 3.0);
}

TEST(Nmea, CountsSentencesWithoutPosition) {
  std::string damaged = Gga("120002");
  damaged[20] = '9';
  const GnssData data = ReadNmea(Rmc("120000", "220625") + Gga("120000") + Gga("120001", "0") +
                                 damaged + Gga("120003") + "garbage\n" + Sentence("GPGSV,1,1,00"));
  EXPECT_EQ(data.epochs.size(), 2u);
  EXPECT_EQ(data.unusable_sentences, 2);
}

TEST(Nmea, RejectsFilesWithoutDateOrPosition) {
  ExpectInvalid([] { ReadNmea(Gga("120000")); }, "gives the date", 0);
  ExpectInvalid([] { ReadNmea(Rmc("120000", "220625")); }, "no GGA sentence", 0);
  ExpectInvalid([] { ReadNmea(Rmc("120000", "990025") + Gga("120000")); }, "no such date", 1);
  ExpectInvalid([] { ReadNmea(Rmc("120000", "220625") + Gga("12:00")); }, "hhmmss", 2);
}

}  // namespace dn::gnss_test
