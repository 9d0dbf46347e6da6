#include <dn/flight/atomic_file.h>

#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn {
namespace {

using testing::ExpectInvalid;
using testing::TempFolder;
namespace fs = std::filesystem;

std::string ContentOf(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::set<std::string> NamesIn(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.insert(entry.path().filename().string());
  }
  return names;
}

TEST(WriteFileAtomically, WritesEveryByteAndNothingElse) {
  const TempFolder folder;
  const std::string content("a\0b\n", 4);
  WriteFileAtomically(folder.path() / "x.bin", content);
  EXPECT_EQ(ContentOf(folder.path() / "x.bin"), content);
  EXPECT_EQ(NamesIn(folder.path()), std::set<std::string>{"x.bin"});
}

TEST(WriteFileAtomically, ReplacesAFile) {
  const TempFolder folder;
  folder.Write("x.txt", "a longer old content");
  WriteFileAtomically(folder.path() / "x.txt", "new");
  EXPECT_EQ(ContentOf(folder.path() / "x.txt"), "new");
}

TEST(WriteFileAtomically, NamesThePathThatCannotBeWritten) {
  const TempFolder folder;
  try {
    WriteFileAtomically(folder.path() / "absent" / "x.txt", "content");
    FAIL() << "no filesystem_error";
  } catch (const fs::filesystem_error& e) {
    EXPECT_THAT(e.path1().string(), ::testing::HasSubstr("absent"));
  }
}

TEST(WriteFileAtomically, LeavesNothingBehindWhenItFails) {
  const TempFolder folder;
  folder.Write("x/inside.txt", "a folder cannot be replaced by a file");
  EXPECT_THROW(WriteFileAtomically(folder.path() / "x", "content"), fs::filesystem_error);
  EXPECT_EQ(NamesIn(folder.path()), std::set<std::string>{"x"});
}

TEST(OutputDirectory, ShowsNothingBeforeCommitAndEverythingAfter) {
  const TempFolder folder;
  const fs::path out = folder.path() / "a" / "out";
  {
    OutputDirectory results(out);
    results.Add("result.json", "{}");
    results.Add("lidar/1_2.txt", "1");
    EXPECT_FALSE(fs::exists(out / "result.json"));
    EXPECT_FALSE(fs::exists(out / "lidar"));
    results.Commit();
  }
  EXPECT_EQ(ContentOf(out / "result.json"), "{}");
  EXPECT_EQ(ContentOf(out / "lidar" / "1_2.txt"), "1");
  EXPECT_EQ(NamesIn(out), (std::set<std::string>{"lidar", "result.json"}));
}

TEST(OutputDirectory, DropsWhatWasNotCommitted) {
  const TempFolder folder;
  folder.Write("out/result.json", "old");
  { OutputDirectory(folder.path() / "out").Add("result.json", "new"); }
  EXPECT_EQ(ContentOf(folder.path() / "out" / "result.json"), "old");
  EXPECT_EQ(NamesIn(folder.path() / "out"), std::set<std::string>{"result.json"});
}

TEST(OutputDirectory, KeepsTheLastOfTwoFilesOfOneName) {
  const TempFolder folder;
  OutputDirectory results(folder.path());
  results.Add("a.txt", "1");
  results.Add("a.txt", "2");
  results.Commit();
  EXPECT_EQ(ContentOf(folder.path() / "a.txt"), "2");
}

TEST(OutputDirectory, CommitsTwice) {
  const TempFolder folder;
  OutputDirectory results(folder.path());
  results.Add("a.txt", "1");
  results.Commit();
  results.Add("b.txt", "2");
  results.Commit();
  EXPECT_EQ(ContentOf(folder.path() / "a.txt"), "1");
  EXPECT_EQ(ContentOf(folder.path() / "b.txt"), "2");
}

TEST(OutputDirectory, RejectsNamesThatLeaveIt) {
  const TempFolder folder;
  OutputDirectory results(folder.path());
  for (const char* name : {"", "../x.txt", "/tmp/x.txt", "a/b/c.txt", "a/", ".."}) {
    SCOPED_TRACE(name);
    ExpectInvalid([&] { results.Add(name, ""); }, "result file name", 0);
  }
}

}  // namespace
}  // namespace dn
