#include <dn/files/atomic_file.h>
#include <sys/stat.h>

#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include "testing/expect_invalid.h"
#include "testing/temp_folder.h"

namespace dn::files_test {

using testing::ExpectInvalid;
using testing::TempFolder;
namespace fs = std::filesystem;

std::string ReadText(const fs::path& file) {
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
  EXPECT_EQ(ReadText(folder.path() / "x.bin"), content);
  EXPECT_EQ(NamesIn(folder.path()), std::set<std::string>{"x.bin"});
}

TEST(WriteFileAtomically, ReplacesAFile) {
  const TempFolder folder;
  folder.Write("x.txt", "a longer old content");
  WriteFileAtomically(folder.path() / "x.txt", "new");
  EXPECT_EQ(ReadText(folder.path() / "x.txt"), "new");
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
  EXPECT_EQ(ReadText(out / "result.json"), "{}");
  EXPECT_EQ(ReadText(out / "lidar" / "1_2.txt"), "1");
  EXPECT_EQ(NamesIn(out), (std::set<std::string>{"lidar", "result.json"}));
}

TEST(OutputDirectory, DropsWhatWasNotCommitted) {
  const TempFolder folder;
  folder.Write("out/result.json", "old");
  { OutputDirectory(folder.path() / "out").Add("result.json", "new"); }
  EXPECT_EQ(ReadText(folder.path() / "out" / "result.json"), "old");
  EXPECT_EQ(NamesIn(folder.path() / "out"), std::set<std::string>{"result.json"});
}

TEST(OutputDirectory, AStagingDirectoryThatWasRemovedStaysSo) {
  const TempFolder folder;
  OutputDirectory results(folder.path() / "out");
  std::filesystem::remove(results.staging());
  EXPECT_ANY_THROW(results.Add("result.json", "new"));
  EXPECT_ANY_THROW(results.Add("lidar/pairs.txt", "new"));
  EXPECT_EQ(NamesIn(folder.path() / "out"), std::set<std::string>{});
}

TEST(OutputDirectory, KeepsTheLastOfTwoFilesOfOneName) {
  const TempFolder folder;
  OutputDirectory results(folder.path());
  results.Add("a.txt", "1");
  results.Add("a.txt", "2");
  results.Commit();
  EXPECT_EQ(ReadText(folder.path() / "a.txt"), "2");
}

TEST(OutputDirectory, CommitsTwice) {
  const TempFolder folder;
  OutputDirectory results(folder.path());
  results.Add("a.txt", "1");
  results.Commit();
  results.Add("b.txt", "2");
  results.Commit();
  EXPECT_EQ(ReadText(folder.path() / "a.txt"), "1");
  EXPECT_EQ(ReadText(folder.path() / "b.txt"), "2");
}

TEST(OutputDirectory, RejectsNamesThatLeaveIt) {
  const TempFolder folder;
  OutputDirectory results(folder.path());
  for (const char* name : {"", "../x.txt", "/tmp/x.txt", "a/b/c.txt", "a/", "..", ".hidden"}) {
    SCOPED_TRACE(name);
    ExpectInvalid([&] { results.Add(name, ""); }, "result file name", 0);
  }
}

TEST(OutputDirectory, CommitsAllOrNothing) {
  const TempFolder folder;
  folder.Write("a.txt", "of the user");
  folder.Write("z.txt/inside.txt", "a folder where a file should go");
  {
    OutputDirectory results(folder.path());
    for (const char* name : {"a.txt", "b.txt", "lidar/1_2.txt", "z.txt"}) results.Add(name, "new");
    EXPECT_THROW(results.Commit(), UnusableOutput);
  }
  EXPECT_EQ(ReadText(folder.path() / "a.txt"), "of the user");
  EXPECT_EQ(NamesIn(folder.path()), (std::set<std::string>{"a.txt", "z.txt"}));
}

TEST(OutputDirectory, AFileThatCannotBeMovedTakesTheOthersBack) {
  const TempFolder folder;
  folder.Write("a.txt", "of the user");
  OutputDirectory results(folder.path());
  for (const char* name : {"a.txt", "lidar/1_2.txt", "z.txt"}) results.Add(name, "new");
  fs::remove(results.staging() / "z.txt");  // as if the disk had failed
  EXPECT_THROW(results.Commit(), fs::filesystem_error);
  EXPECT_EQ(ReadText(folder.path() / "a.txt"), "of the user");
  EXPECT_FALSE(fs::exists(folder.path() / "lidar"));
}

TEST(OutputDirectory, ALinkIsNoFolderForResults) {
  const TempFolder folder;
  folder.Write("elsewhere/1_2.txt", "of the user");
  fs::create_directory(folder.path() / "out");
  fs::create_directory_symlink(folder.path() / "elsewhere", folder.path() / "out/lidar");
  OutputDirectory results(folder.path() / "out");
  results.Add("lidar/1_2.txt", "new");
  EXPECT_THROW(results.Commit(), UnusableOutput);
  results.Remove({"lidar/1_2.txt"});
  EXPECT_EQ(ReadText(folder.path() / "elsewhere/1_2.txt"), "of the user");
}

TEST(OutputDirectory, ASecondRunIsRefusedWhileTheFirstOneLives) {
  const TempFolder folder;
  {
    OutputDirectory first(folder.path());
    first.Add("a.txt", "1");
    EXPECT_THROW(OutputDirectory{folder.path()}, UnusableOutput);
    first.Commit();
  }
  EXPECT_EQ(ReadText(folder.path() / "a.txt"), "1");
  EXPECT_NO_THROW(OutputDirectory{folder.path()});
}

TEST(OutputDirectory, WhatAKilledRunStagedIsSwept) {
  const TempFolder folder;
  folder.Write(".dn-staging-Abc123/lidar/1_2.txt", "staged");
  folder.Write(".dn-staging-short/a.txt", "of the user");
  folder.Write("elsewhere/a.txt", "of the user");
  fs::create_directory_symlink("elsewhere", folder.path() / ".dn-staging-link00");
  { const OutputDirectory results(folder.path()); }
  EXPECT_EQ(NamesIn(folder.path()),
            (std::set<std::string>{".dn-staging-link00", ".dn-staging-short", "elsewhere"}));
  EXPECT_EQ(ReadText(folder.path() / "elsewhere/a.txt"), "of the user");
}

/// Returns the first line of a journal that a run writes in `folder`/`staging`, which must exist.
std::string FirstLine(const fs::path& folder, const std::string& staging) {
  std::string line = "dn.commit/1";
  for (const fs::path& directory : {folder, folder / staging}) {
    struct stat status {};
    EXPECT_EQ(::stat(directory.c_str(), &status), 0) << directory;
    line += " " + std::to_string(status.st_ino);
  }
  return line + "\n";
}

TEST(OutputDirectory, AHalfCommitOfAKilledRunIsUndone) {
  const TempFolder folder;
  folder.Write(".dn-staging-Abc123/empty", "");
  folder.Write(".dn-staging-Abc123/.commit", FirstLine(folder.path(), ".dn-staging-Abc123") +
                                                 "a.txt\nb.txt\nlidar/1_2.txt\nz.txt\n");
  folder.Write(".dn-staging-Abc123/.replaced/a.txt", "of the user");
  folder.Write(".dn-staging-Abc123/z.txt", "new");
  folder.Write("a.txt", "new");
  folder.Write("b.txt", "new");
  folder.Write("lidar/1_2.txt", "new");
  folder.Write("z.txt", "of the user");
  { const OutputDirectory results(folder.path()); }
  EXPECT_EQ(NamesIn(folder.path()), (std::set<std::string>{"a.txt", "z.txt"}));
  EXPECT_EQ(ReadText(folder.path() / "a.txt"), "of the user");
  EXPECT_EQ(ReadText(folder.path() / "z.txt"), "of the user");
}

/// A results folder with a planted journal of a commit that names files outside of the folder.
class PlantedJournal {
 public:
  PlantedJournal() {
    folder_.Write("victim", "of the user");
    folder_.Write("bashrc", "of the user");
    folder_.Write("elsewhere/1_2.txt", "of the user");
    folder_.Write("out/result.json", "of the user");
    folder_.Write("out/.dn-staging-Abc123/bashrc", "evil");
    folder_.Write("out/.dn-staging-Abc123/.replaced/result.json", "evil");
  }

  fs::path Staging() const { return folder_.path() / "out/.dn-staging-Abc123"; }
  void Write(const std::string& text) const {
    folder_.Write("out/.dn-staging-Abc123/.commit", text);
  }
  /// Writes a journal with the first line that a run of this program would write.
  void WriteOurs(const std::string& names) const {
    Write(FirstLine(folder_.path() / "out", ".dn-staging-Abc123") + names);
  }

  void ExpectRefused(const std::string& why) const {
    try {
      const OutputDirectory results(folder_.path() / "out");
      FAIL() << "the journal was believed";
    } catch (const UnusableOutput& error) {
      EXPECT_THAT(error.what(), ::testing::HasSubstr(".dn-staging-Abc123/.commit"));
      EXPECT_THAT(error.what(), ::testing::HasSubstr(why));
      EXPECT_THAT(error.what(), ::testing::HasSubstr("; delete "));
    }
    ExpectUntouched();
  }

  void ExpectUntouched() const {
    for (const char* name : {"victim", "bashrc", "elsewhere/1_2.txt", "out/result.json"}) {
      EXPECT_EQ(ReadText(folder_.path() / name), "of the user") << name;
    }
  }

  const fs::path& path() const { return folder_.path(); }

 private:
  TempFolder folder_;
};

TEST(OutputDirectory, AJournalOfAnotherPlaceIsRefused) {
  for (const std::string text : {"", "../victim\n../bashrc\n", "result.json\n",
                                 "dn.commit/1\nresult.json\n", "dn.commit/1 1 2\nresult.json\n"}) {
    SCOPED_TRACE(text);
    const PlantedJournal planted;
    planted.Write(text);
    planted.ExpectRefused("it was written for another folder");
  }
}

TEST(OutputDirectory, AJournalInACopyOfAFolderIsRefused) {
  const PlantedJournal planted;
  planted.WriteOurs("result.json\n");
  fs::copy(planted.path() / "out", planted.path() / "copy", fs::copy_options::recursive);
  EXPECT_THROW(OutputDirectory{planted.path() / "copy"}, UnusableOutput);
  EXPECT_EQ(ReadText(planted.path() / "copy/result.json"), "of the user");
}

TEST(OutputDirectory, AJournalNamesNothingOutside) {
  for (const std::string& name :
       {std::string("../victim"), std::string("a/../../bashrc"), std::string("/tmp"),
        std::string("a/b/c"), std::string("."), std::string(".."), std::string(""),
        std::string(".dn-staging-Abc123/x"), std::string("lidar/")}) {
    SCOPED_TRACE(name);
    const PlantedJournal planted;
    planted.WriteOurs("absent.txt\n" + name + "\n");
    planted.ExpectRefused("it names a file that is not a result");
  }
}

TEST(OutputDirectory, AJournalReachesNothingThroughALink) {
  for (const std::string link :
       {"lidar", ".dn-staging-Abc123/lidar", ".dn-staging-Abc123/.replaced/lidar"}) {
    SCOPED_TRACE(link);
    const PlantedJournal planted;
    fs::create_directory_symlink(planted.path() / "elsewhere", planted.path() / "out" / link);
    planted.WriteOurs("lidar/1_2.txt\n");
    planted.ExpectRefused("is not a folder");
  }
  const PlantedJournal planted;
  fs::remove_all(planted.Staging() / ".replaced");
  fs::create_directory_symlink(planted.path(), planted.Staging() / ".replaced");
  planted.WriteOurs("victim\n");
  planted.ExpectRefused("is not a folder");
}

TEST(OutputDirectory, AJournalIsARegularFile) {
  const PlantedJournal fifo;
  ASSERT_EQ(::mkfifo((fifo.Staging() / ".commit").c_str(), 0600), 0);
  fifo.ExpectRefused("a named pipe");
  const PlantedJournal folder;
  fs::create_directory(folder.Staging() / ".commit");
  folder.ExpectRefused("a folder");
  for (const char* target : {"/dev/zero", "../../victim", "nowhere"}) {
    const PlantedJournal link;
    fs::create_symlink(target, link.Staging() / ".commit");
    link.ExpectRefused("it is a link");
  }
}

TEST(OutputDirectory, AStagingFolderThatIsALinkIsLeftAlone) {
  const PlantedJournal planted;
  planted.WriteOurs("result.json\n");
  fs::rename(planted.Staging(), planted.path() / "staging");
  fs::create_directory_symlink(planted.path() / "staging", planted.Staging());
  { const OutputDirectory results(planted.path() / "out"); }
  planted.ExpectUntouched();
  EXPECT_EQ(ReadText(planted.path() / "staging/bashrc"), "evil");
}

TEST(OutputDirectory, StagesWhereNobodyElseMayEnter) {
  const TempFolder folder;
  const OutputDirectory results(folder.path());
  EXPECT_EQ(fs::status(results.staging()).permissions(), fs::perms::owner_all);
  EXPECT_EQ(results.staging().parent_path(), folder.path());
}

TEST(OutputDirectory, NeverReplacesAnInput) {
  const TempFolder folder;
  folder.Write("data/GPS.txt", "of the user");
  fs::create_directory(folder.path() / "out");
  fs::create_hard_link(folder.path() / "data/GPS.txt", folder.path() / "out/GPS.txt");
  OutputDirectory results(folder.path() / "out");
  results.Protect({folder.path() / "data/../data/GPS.txt"});
  EXPECT_THROW(results.Add("GPS.txt", "new"), InvalidConfig);
  EXPECT_NO_THROW(results.Add("IMU.txt", "new"));
}

TEST(OutputDirectory, RemovesFilesAndWhatBecomesEmpty) {
  const TempFolder folder;
  folder.Write("out/a.txt", "");
  folder.Write("out/lidar/1_2.txt", "");
  folder.Write("out/strips/1.txt", "");
  folder.Write("out/strips/notes.txt", "of the user");
  folder.Write("out/folder/x/y.txt", "");
  folder.Write("outside.txt", "");
  const OutputDirectory results(folder.path() / "out");
  results.Remove({"a.txt", "lidar/1_2.txt", "strips/1.txt", "folder", "absent.txt",
                  "../outside.txt", (folder.path() / "outside.txt").string()});
  fs::remove_all(results.staging());
  EXPECT_EQ(NamesIn(folder.path() / "out"), (std::set<std::string>{"folder", "strips"}));
  EXPECT_EQ(NamesIn(folder.path() / "out/strips"), std::set<std::string>{"notes.txt"});
  EXPECT_TRUE(fs::exists(folder.path() / "outside.txt"));
}

}  // namespace dn::files_test
