#include <dn/geo/read_file.h>
#include <dn/lidar/strip_io.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "testing/expect_invalid.h"
#include "testing/las_bytes.h"
#include "testing/laz_records.h"
#include "testing/temp_folder.h"

namespace dn::lidar_test {

using testing::ExpectInvalidIn;
using testing::LasBytes;
using testing::LasPoint;
using testing::LazRecords;
using testing::TempFolder;

namespace fs = std::filesystem;

/// Returns the records of all points of a strip.
std::string Records(const fs::path& file) {
  const auto reader = OpenStrip(file);
  std::string records;
  for (StripCloud points; reader->Next(&points);) records += points.records;
  return records;
}

/// Copies a strip; the name of the new file selects its kind.
void CopyStrip(const fs::path& from, const fs::path& to, const StripAdditions& additions = {}) {
  const auto reader = OpenStrip(from);
  const auto writer = reader->MakeWriter(to, additions);
  for (StripCloud points; reader->Next(&points);) {
    points.covariance_c_m2.assign(points.size(), Eigen::Matrix3d::Identity());
    writer->Append(points);
  }
  writer->Finish();
}

/// Returns a LAS file with generated records.
std::string GeneratedLas(int minor, int format, std::size_t extra_bytes, std::size_t points,
                         const std::vector<testing::LasRecord>& evlrs = {}) {
  const LazRecords records(format, extra_bytes, points, 1);
  LasBytes las;
  las.minor = minor;
  las.format = format;
  las.extra_bytes = extra_bytes;
  las.vlrs = {{"somebody", 7, "what nobody knows"}};
  las.evlrs = evlrs;
  las.points.resize(points);
  std::string bytes = las.Build();
  const std::size_t begin = las.HeaderBytes() + 54 + 17;
  return bytes.replace(begin, records.bytes().size(), records.bytes());
}

struct LazFormat {
  int minor, format;
};

class EveryLazFormat : public ::testing::TestWithParam<LazFormat> {};

TEST_P(EveryLazFormat, IsWrittenAndReadByItsName) {
  const TempFolder folder;
  const auto [minor, format] = GetParam();
  // The first copy has the header as this project writes it.
  folder.Write("given.las", GeneratedLas(minor, format, 5, 70000));
  const auto file = [&](const char* name) { return folder.path() / name; };
  CopyStrip(file("given.las"), file("plain.las"));
  CopyStrip(file("plain.las"), file("packed.laz"));
  CopyStrip(file("packed.laz"), file("again.LAZ"));
  CopyStrip(file("again.LAZ"), file("unpacked.las"));
  EXPECT_LT(fs::file_size(file("packed.laz")), fs::file_size(file("plain.las")) * 3 / 4);
  EXPECT_EQ(ReadWholeFile(file("packed.laz")), ReadWholeFile(file("again.LAZ")));
  EXPECT_EQ(ReadWholeFile(file("plain.las")), ReadWholeFile(file("unpacked.las")));
  EXPECT_EQ(OpenStrip(file("packed.laz"))->points(), 70000u);
  EXPECT_EQ(Records(file("packed.laz")), Records(file("given.las")));
}

INSTANTIATE_TEST_SUITE_P(Laz, EveryLazFormat,
                         ::testing::Values(LazFormat{2, 0}, LazFormat{2, 1}, LazFormat{2, 2},
                                           LazFormat{2, 3}, LazFormat{3, 4}, LazFormat{3, 5},
                                           LazFormat{4, 1}, LazFormat{4, 6}, LazFormat{4, 7},
                                           LazFormat{4, 8}, LazFormat{4, 9}, LazFormat{4, 10}),
                         [](const auto& test) {
                           return "v1" + std::to_string(test.param.minor) + "format" +
                                  std::to_string(test.param.format);
                         });

TEST(Laz, IsRecognisedByContent) {
  const TempFolder folder;
  folder.Write("plain.las", GeneratedLas(4, 6, 0, 100));
  CopyStrip(folder.path() / "plain.las", folder.path() / "packed.laz");
  fs::rename(folder.path() / "packed.laz", folder.path() / "strip.las");
  EXPECT_EQ(Records(folder.path() / "strip.las"), Records(folder.path() / "plain.las"));
  fs::rename(folder.path() / "plain.las", folder.path() / "plain.laz");
  EXPECT_EQ(Records(folder.path() / "plain.laz"), Records(folder.path() / "strip.las"));
}

TEST(Laz, MayHaveNoPoints) {
  const TempFolder folder;
  folder.Write("plain.las", GeneratedLas(4, 6, 0, 0));
  CopyStrip(folder.path() / "plain.las", folder.path() / "packed.laz");
  EXPECT_EQ(Records(folder.path() / "packed.laz"), "");
  CopyStrip(folder.path() / "packed.laz", folder.path() / "again.laz");
  EXPECT_EQ(OpenStrip(folder.path() / "again.laz")->points(), 0u);
}

TEST(Laz, ANewStripIsCompressedByItsName) {
  const TempFolder folder;
  StripCloud points;
  for (int i = 0; i < 1000; ++i) {
    points.p_c.emplace_back(i, 0.1 * i, 30.0);
    points.t_s.push_back(381000.0 + 1e-5 * i);
    points.u_s.emplace_back(0.1 * i, -1.0, 400.0 + 0.25 * (i % 8));
  }
  for (const char* name : {"new.las", "new.laz"}) {
    const auto writer = NewLasStrip(folder.path() / name, {});
    writer->Append(points);
    writer->Finish();
  }
  EXPECT_EQ(Records(folder.path() / "new.laz"), Records(folder.path() / "new.las"));
  EXPECT_LT(fs::file_size(folder.path() / "new.laz"), fs::file_size(folder.path() / "new.las") / 2);
}

TEST(Laz, AdditionsEnlargeTheRecords) {
  const TempFolder folder;
  folder.Write("plain.las", GeneratedLas(4, 7, 3, 5000));
  CopyStrip(folder.path() / "plain.las", folder.path() / "packed.laz");
  const StripAdditions additions{.covariance = true,
                                 .boresight_rad = Eigen::Vector3d(0.01, 0.02, 0.03)};
  CopyStrip(folder.path() / "plain.las", folder.path() / "more.las", additions);
  CopyStrip(folder.path() / "packed.laz", folder.path() / "more.laz", additions);
  EXPECT_EQ(Records(folder.path() / "more.laz"), Records(folder.path() / "more.las"));
  EXPECT_TRUE(OpenStrip(folder.path() / "more.laz")->boresight_rad());
}

TEST(Laz, DataAfterThePointsAreKept) {
  const TempFolder folder;
  folder.Write("plain.las",
               GeneratedLas(4, 6, 0, 1000, {{"somebody", 1, "first"}, {"somebody", 2, "second"}}));
  const auto file = [&](const char* name) { return folder.path() / name; };
  CopyStrip(file("plain.las"), file("same.las"));
  CopyStrip(file("plain.las"), file("packed.laz"));
  CopyStrip(file("packed.laz"), file("again.laz"));
  CopyStrip(file("again.laz"), file("unpacked.las"));
  EXPECT_EQ(ReadWholeFile(file("unpacked.las")), ReadWholeFile(file("same.las")));
}

TEST(Laz, PositionsOfPointsAreMarkedAsSuperseded) {
  const TempFolder folder;
  folder.Write("plain.las", GeneratedLas(4, 6, 0, 1000, {{"copc", 1000, "positions"}}));
  CopyStrip(folder.path() / "plain.las", folder.path() / "packed.laz");
  const std::string packed = ReadWholeFile(folder.path() / "packed.laz");
  EXPECT_EQ(packed.find("copc"), std::string::npos);
  const std::size_t record = packed.size() - std::strlen("positions") - 60;
  EXPECT_EQ(packed.substr(record + 2, 9), "LASF_Spec");
  EXPECT_EQ(packed[record + 18], 7);
}

/// Returns a small file that is compressed as a name says.
std::string Packed(const std::string& las) {
  const TempFolder folder;
  folder.Write("plain.las", las);
  CopyStrip(folder.path() / "plain.las", folder.path() / "packed.laz");
  return ReadWholeFile(folder.path() / "packed.laz");
}

TEST(LazFaults, FalseStatementsAreReported) {
  const std::string laz = Packed(GeneratedLas(4, 6, 0, 1000));
  const std::size_t vlr = 375 + 54 + 17;
  const std::size_t content = vlr + 54;
  const std::size_t points = content + 34 + 6;
  const auto with = [&](std::size_t at, auto value, const std::string& what) {
    SCOPED_TRACE("byte " + std::to_string(at));
    const TempFolder folder;
    std::string bytes = laz;
    LasBytes::Put(value, at, &bytes);
    folder.Write("strip.laz", bytes);
    ExpectInvalidIn([&] { Records(folder.path() / "strip.laz"); }, what, "strip.laz");
  };
  with(vlr + 2, 'x', "the record that says how is missing");
  with(content, std::uint16_t{2}, "compressor 2 with coder 0 is not supported for point format 6");
  with(content + 36, std::uint16_t{31}, "where the point format needs one of type 10");
  with(points, std::int64_t{0}, "the table of the chunks is said to begin at byte 0");
  with(points, std::int64_t{1} << 40, "the table of the chunks is said to begin");
  with(247, std::uint64_t{999}, "a chunk of 999 points says that it has 1000");
  with(247, std::uint64_t{50001}, "the chunks have 50000 points, but the header announces 50001");
  with(247, std::uint64_t{1} << 62, "the chunks have 50000 points");
  with(points + 8 + 30 + 4, ~std::uint32_t{0}, "the layers of a chunk are longer than the chunk");
  with(points + 8 + 30 + 4, std::uint32_t{0}, "a chunk lacks its first layer");
}

/// Reads a damaged file again and again. The only allowed exception is InvalidInput.
class DamagedFile {
 public:
  /// Returns true if the points are read, false if they are rejected.
  bool Read(const std::string& bytes) const {
    folder_.Write("strip.laz", bytes);
    try {
      Records(folder_.path() / "strip.laz");
      return true;
    } catch (const InvalidInput& e) {
      EXPECT_STRNE(e.what(), "");
      return false;
    }
  }

 private:
  TempFolder folder_;
};

class DamagedLaz : public ::testing::TestWithParam<LazFormat> {};

TEST_P(DamagedLaz, ATruncatedFileIsRejected) {
  const std::string laz = Packed(GeneratedLas(GetParam().minor, GetParam().format, 2, 300));
  const DamagedFile file;
  EXPECT_TRUE(file.Read(laz));
  for (std::size_t length = 0; length < laz.size(); length += 7) {
    EXPECT_FALSE(file.Read(laz.substr(0, length))) << length;
  }
}

TEST_P(DamagedLaz, EveryChangedByteIsReadOrRejected) {
  const std::string laz = Packed(GeneratedLas(GetParam().minor, GetParam().format, 2, 25));
  const DamagedFile file;
  for (std::size_t at = 0; at < laz.size(); ++at) {
    std::string bytes = laz;
    bytes[at] = static_cast<char>(~bytes[at]);
    EXPECT_NO_THROW(file.Read(bytes)) << at;
  }
}

INSTANTIATE_TEST_SUITE_P(Laz, DamagedLaz,
                         ::testing::Values(LazFormat{2, 3}, LazFormat{3, 5}, LazFormat{4, 8},
                                           LazFormat{4, 10}),
                         [](const auto& test) { return std::to_string(test.param.format); });

/// Files of other programs outside this project; the tests are skipped if they are absent.
class FilesOfOthers : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(Data(""))) GTEST_SKIP() << "no files of other programs: " << Data("");
  }

  static fs::path Data(const std::string& name) {
    return fs::path(DN_SHARED_DATA_DIR) / "data/laz" / name;
  }

  /// Returns a copy of a file without its coordinate system, which is in feet for some of them.
  fs::path WithoutUnits(const std::string& name) const {
    constexpr std::string_view kUser = "LASF_Projection";
    std::string bytes = ReadWholeFile(Data(name));
    for (std::size_t at = 0; (at = bytes.find(kUser, at)) != std::string::npos;) bytes[at] = '-';
    folder_.Write(name, bytes);
    return folder_.path() / name;
  }

 private:
  TempFolder folder_;
};

TEST_F(FilesOfOthers, HaveThePointsOfTheirUncompressedFiles) {
  EXPECT_EQ(Records(Data("simple.laz")), Records(Data("simple.las")));
  EXPECT_EQ(Records(Data("simple.laszip12.laz")), Records(Data("simple.las")));
  for (const char* name : {"laszip", "padding", "liblas"}) {
    EXPECT_EQ(Records(Data(std::string("basefile.") + name + ".laz")),
              Records(Data("basefile.las")))
        << name;
  }
}

/// Intensity, time and colour of a point, as in its record, and its position.
using ColouredPoint = std::pair<std::string, Eigen::Vector3d>;

std::vector<ColouredPoint> SortedPoints(const fs::path& file, std::size_t time_at,
                                        std::size_t colour_at) {
  std::vector<ColouredPoint> sorted;
  const auto reader = OpenStrip(file);
  for (StripCloud points; reader->Next(&points);) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      const std::string record =
          points.records.substr(i * points.record_bytes, points.record_bytes);
      sorted.emplace_back(
          record.substr(12, 2) + record.substr(time_at, 8) + record.substr(colour_at, 6),
          points.p_c[i]);
    }
  }
  std::sort(sorted.begin(), sorted.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  return sorted;
}

TEST_F(FilesOfOthers, VariableChunksHaveTheSamePointsInAnotherOrder) {
  const auto copc = SortedPoints(WithoutUnits("colour.copc.laz"), 22, 30);
  const auto las = SortedPoints(Data("colour.las"), 20, 28);
  ASSERT_EQ(copc.size(), las.size());
  for (std::size_t i = 0; i < las.size(); ++i) {
    EXPECT_EQ(copc[i].first, las[i].first);
    EXPECT_LT((copc[i].second - las[i].second).norm(), 0.02);
  }
}

TEST_F(FilesOfOthers, FillTheBoundsOfTheirHeaders) {
  for (const char* name : {"autzen_trim.laz", "Topography.laz", "Tent.laz", "extra_bytes.laz"}) {
    SCOPED_TRACE(name);
    const fs::path file = WithoutUnits(name);
    const std::string head = ReadWholeFile(file).substr(0, 227);
    Eigen::Vector3d most, least;
    for (int i = 0; i < 3; ++i) {
      std::memcpy(&most[i], head.data() + 179 + 16 * i, 8);
      std::memcpy(&least[i], head.data() + 187 + 16 * i, 8);
    }
    const auto reader = OpenStrip(file);
    Eigen::Vector3d largest = least, smallest = most;
    std::size_t read = 0;
    for (StripCloud points; reader->Next(&points); read += points.size()) {
      for (const Eigen::Vector3d& p_c : points.p_c) {
        largest = largest.cwiseMax(p_c);
        smallest = smallest.cwiseMin(p_c);
      }
    }
    EXPECT_EQ(read, reader->points());
    EXPECT_LT((largest - most).norm(), 0.01);
    EXPECT_LT((smallest - least).norm(), 0.01);
  }
}

TEST_F(FilesOfOthers, AreCopiedWithoutLoss) {
  const TempFolder folder;
  for (const char* name : {"simple.laszip12.laz", "colour.copc.laz", "Topography.laz"}) {
    const fs::path file = WithoutUnits(name);
    CopyStrip(file, folder.path() / name);
    EXPECT_EQ(Records(folder.path() / name), Records(file)) << name;
  }
}

}  // namespace dn::lidar_test
