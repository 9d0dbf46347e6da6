#include <dn/geo/file_writer.h>
#include <dn/geo/read_file.h>
#include <gtest/gtest.h>

#include "testing/temp_folder.h"

namespace dn::geo_test {

namespace fs = std::filesystem;

TEST(FileWriter, AppearsWhenItIsPublishedWithWhatWasOverwritten) {
  const testing::TempFolder folder;
  const fs::path path = folder.path() / "points.las";
  FileWriter file(path);
  file.Append("header ");
  file.Append("points");
  file.Overwrite(0, "HEAD");
  file.Append("!");
  EXPECT_FALSE(fs::exists(path));
  file.Publish();
  EXPECT_EQ(ReadWholeFile(path), "HEADer points!");
}

TEST(FileWriter, LeavesNothingWithoutPublish) {
  const testing::TempFolder folder;
  { FileWriter(folder.path() / "points.las").Append("header"); }
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(FileWriter, NamesTheFolderThatIsNotThere) {
  const testing::TempFolder folder;
  EXPECT_THROW(FileWriter(folder.path() / "none" / "points.las"), fs::filesystem_error);
}

}  // namespace dn::geo_test
