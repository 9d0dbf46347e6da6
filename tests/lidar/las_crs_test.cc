#include <dn/lidar/strip_io.h>
#include <gtest/gtest.h>

#include "testing/expect_invalid.h"
#include "testing/las_bytes.h"
#include "testing/temp_file.h"

namespace dn::lidar_test {

using testing::ExpectInvalidIn;
using testing::LasBytes;
using testing::LasRecord;
using testing::TempFile;

constexpr std::uint16_t kWkt = 2112, kGeoKeys = 34735, kGeoAscii = 34737;

StripCrs ReadCrs(const std::vector<LasRecord>& vlrs, const std::vector<LasRecord>& evlrs = {}) {
  LasBytes las;
  las.minor = 4;
  las.points.resize(1);
  las.vlrs = vlrs;
  las.evlrs = evlrs;
  return OpenStrip(TempFile("strip.las", las.Build()).path())->crs();
}

LasRecord Wkt(const std::string& text) { return {"LASF_Projection", kWkt, text}; }

LasRecord GeoKeys(const std::vector<std::array<std::uint16_t, 4>>& keys) {
  LasRecord record{"LASF_Projection", kGeoKeys, std::string(8 * (keys.size() + 1), '\0')};
  const auto count = static_cast<std::uint16_t>(keys.size());
  LasBytes::Put(std::array<std::uint16_t, 4>{1, 1, 0, count}, 0, &record.content);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    LasBytes::Put(keys[i], 8 * (i + 1), &record.content);
  }
  return record;
}

TEST(LasCrs, FileWithoutSystem) {
  const StripCrs crs = ReadCrs({});
  EXPECT_FALSE(crs.epsg);
  EXPECT_EQ(crs.text, "");
  EXPECT_EQ(crs.name, "");
}

TEST(LasCrs, GeoTiffKeys) {
  const StripCrs utm = ReadCrs(
      {GeoKeys({{1024, 0, 1, 1}, {1026, kGeoAscii, 5, 0}, {3072, 0, 1, 32632}, {4096, 0, 1, 5703}}),
       {"LASF_Projection", kGeoAscii, "WGS84|"}});
  EXPECT_EQ(utm.epsg, 32632);
  EXPECT_EQ(utm.name, "utm:32n");
  EXPECT_EQ(utm.text, "WGS84");
  EXPECT_TRUE(utm.heights_from_geoid);
  EXPECT_EQ(ReadCrs({GeoKeys({{1024, 0, 1, 1}, {3072, 0, 1, 32767}, {3074, 0, 1, 16134}})}).name,
            "utm:34s");
  const StripCrs ecef = ReadCrs({GeoKeys({{1024, 0, 1, 3}, {2048, 0, 1, 4326}})});
  EXPECT_EQ(ecef.name, "ecef");
  EXPECT_EQ(ecef.epsg, 4978);
  const StripCrs degrees = ReadCrs({GeoKeys({{1024, 0, 1, 2}, {2048, 0, 1, 4326}})});
  EXPECT_EQ(degrees.name, "");
  EXPECT_EQ(degrees.epsg, 4326);
}

TEST(LasCrs, GeoTiffKeysOfAnyProjectedSystem) {
  const auto name = [](const std::vector<std::array<std::uint16_t, 4>>& keys) {
    return ReadCrs({GeoKeys(keys)}).name;
  };
  EXPECT_EQ(name({{1024, 0, 1, 1}, {3072, 0, 1, 3005}}), "epsg:3005");
  // California zone 3 is in US survey feet.
  EXPECT_EQ(name({{1024, 0, 1, 1}, {3072, 0, 1, 2227}, {3076, 0, 1, 9003}}), "epsg:2227");
  EXPECT_EQ(name({{1024, 0, 1, 1}, {3072, 0, 1, 2227}, {4099, 0, 1, 9003}}),
            "epsg:2227 heights:us-ft");
  EXPECT_EQ(name({{1024, 0, 1, 1}, {3072, 0, 1, 32632}, {4099, 0, 1, 9002}}), "utm:32n heights:ft");
  EXPECT_FALSE(ReadCrs({GeoKeys({{1024, 0, 1, 1}, {3072, 0, 1, 2227}})}).in_metres);
  ExpectInvalidIn(
      [&] {
        name({{1024, 0, 1, 1}, {3072, 0, 1, 32632}, {3076, 0, 1, 9003}});
      },
      "the coordinates of the points are not in metres", "strip.las");
}

TEST(LasCrs, BrokenGeoTiffKeys) {
  LasRecord keys = GeoKeys({{1024, 0, 1, 1}});
  LasBytes::Put(std::uint16_t{9}, 6, &keys.content);
  ExpectInvalidIn([&] { ReadCrs({keys}); }, "announces 9 keys", "strip.las");
  ExpectInvalidIn(
      [&] {
        ReadCrs({{"LASF_Projection", kGeoKeys, "x"}});
      },
      "announces 0 keys", "strip.las");
  EXPECT_EQ(ReadCrs({GeoKeys({{1026, kGeoAscii, 60000, 60000}})}).text, "");
}

TEST(LasCrs, WellKnownTextOf2001) {
  const std::string projected =
      R"(PROJCS["ETRS89 / UTM zone 33N",GEOGCS["ETRS89",DATUM["x",SPHEROID["y",6378137,298.25,)"
      R"(AUTHORITY["EPSG","7019"]]],UNIT["degree",0.0174532925],AUTHORITY["EPSG","4258"]],)"
      R"(UNIT["metre",1,AUTHORITY["EPSG","9001"]],AUTHORITY["EPSG","25833"]])";
  const StripCrs crs = ReadCrs({Wkt(projected + '\0')});
  EXPECT_EQ(crs.epsg, 25833);
  EXPECT_EQ(crs.name, "utm:33n");
  EXPECT_FALSE(crs.heights_from_geoid);
  const StripCrs compound =
      ReadCrs({}, {Wkt("COMPD_CS[\"both\"," + projected +
                       R"(,VERT_CS["h",UNIT["metre",1]],AUTHORITY["EPSG","5972"]])")});
  EXPECT_EQ(compound.epsg, 25833);
  EXPECT_TRUE(compound.heights_from_geoid);
}

TEST(LasCrs, WellKnownTextOf2019) {
  const StripCrs crs =
      ReadCrs({Wkt(R"(PROJCRS["WGS 84 / UTM zone 56S", BASEGEOGCRS["WGS 84", ID["EPSG",4326]], )"
                   R"(CONVERSION["x", ID["EPSG",16156]], CS[Cartesian,2], LENGTHUNIT["metre",1], )"
                   R"(ID["EPSG",32756]])")});
  EXPECT_EQ(crs.epsg, 32756);
  EXPECT_EQ(crs.name, "utm:56s");
}

TEST(LasCrs, FindsTheZoneInTheTitle) {
  EXPECT_EQ(ReadCrs({Wkt(R"(PROJCS["WGS 84 / UTM zone 11N",UNIT["metre",1]])")}).name, "utm:11n");
  EXPECT_EQ(ReadCrs({Wkt(R"(PROJCS["WGS 84 / UTM zone ",UNIT["metre",1]])")}).name, "");
}

TEST(LasCrs, FeetAreRefused) {
  ExpectInvalidIn(
      [] { ReadCrs({Wkt(R"(PROJCS["x",UNIT["US survey foot",0.3048006096012192]])")}); },
      "the coordinates of the points are not in metres", "strip.las");
  ExpectInvalidIn(
      [] {
        ReadCrs({Wkt(R"(COMPD_CS["x",PROJCS["x",UNIT["m",1]],VERT_CS["h",UNIT["foot",0.3048]]])")});
      },
      "the heights of the points are not in metres", "strip.las");
  ExpectInvalidIn(
      [] {
        ReadCrs({GeoKeys({{1024, 0, 1, 1}, {3076, 0, 1, 9003}})});
      },
      "the coordinates of the points are not in metres", "strip.las");
}

TEST(LasCrs, HeightsInFeetAreConvertedOrRefused) {
  const std::string plane = R"(PROJCS["x",UNIT["metre",1]])";
  const std::string esri = plane + R"(,VERTCS["NAVD88",UNIT["Foot_US",0.3048006096012192]])";
  const LasRecord code = GeoKeys({{1024, 0, 1, 1}, {3072, 0, 1, 32632}, {4096, 0, 1, 6360}});
  const LasRecord unit = GeoKeys({{1024, 0, 1, 1}, {3072, 0, 1, 32632}, {4099, 0, 1, 9003}});
  EXPECT_EQ(ReadCrs({code}).name, "utm:32n heights:us-ft");
  EXPECT_EQ(ReadCrs({unit}).name, "utm:32n heights:us-ft");
  const std::vector<std::vector<LasRecord>> cases{
      {Wkt(esri)}, {Wkt(plane), code}, {Wkt(plane), unit}};
  for (const std::vector<LasRecord>& records : cases) {
    ExpectInvalidIn([&] { ReadCrs(records); }, "the heights of the points are not in metres",
                    "strip.las");
  }
  EXPECT_TRUE(ReadCrs({Wkt(plane + R"(,VERTCS["NAVD88",UNIT["Meter",1.0]])")}).heights_from_geoid);
  // Text with a vertical system takes precedence over the keys.
  EXPECT_TRUE(
      ReadCrs({Wkt(R"(COMPD_CS["x",PROJCS["x",UNIT["m",1]],VERT_CS["h",UNIT["m",1]]])"), code})
          .heights_from_geoid);
  const LasRecord metres = GeoKeys({{1024, 0, 1, 1}, {4096, 0, 1, 5703}, {4099, 0, 1, 9001}});
  EXPECT_TRUE(ReadCrs({Wkt(plane), metres}).heights_from_geoid);
}

TEST(LasCrs, BrokenTextIsKept) {
  for (const char* text :
       {"[[[[", "]]]]", "PROJCS[\"", "PROJCS[\"x\",UNIT[\"m\",abc]", ",,,\"\""}) {
    EXPECT_FALSE(ReadCrs({Wkt(text)}).epsg) << text;
    EXPECT_EQ(ReadCrs({Wkt(text)}).text, text);
  }
}

// The run time stays within the limit of a test because each bracket counts the enclosing systems
// only once.
TEST(LasCrs, DeeplyNestedTextTakesNoTime) {
  std::string text;
  constexpr int kDepth = 80000;
  for (int i = 0; i < kDepth; ++i) text += "PROJCS[1,2,";
  EXPECT_FALSE(ReadCrs({}, {Wkt(text + std::string(kDepth, ']'))}).epsg);
}

}  // namespace dn::lidar_test
