// Text that the program sends to a terminal or offers to a shell.
#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <sstream>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

const char* const kControls = "\x1b[31mred\x07\x7f";
const char* const kShown = "\\x1B[31mred\\x07\\x7F";

void ExpectFitForTerminal(const std::string& text) {
  for (const char c : text) EXPECT_FALSE((c >= 0 && c < ' ' && c != '\n') || c == '\x7f') << text;
}

TEST(CliTerminal, AResultReachesItWithoutControlCharacters) {
  const TempFolder folder;
  fs::create_directory(folder.path() / "r");
  for (const auto& entry : fs::directory_iterator(SmoothResult())) {
    std::string content = FileContent(entry.path());
    const std::string name = "\"flight\": \"short\"";
    const std::size_t at = content.find(name);
    if (at != std::string::npos) {
      content.replace(at, name.size(), "\"flight\": \"\\u001b[31mred\\u0007\\u007f\"");
    }
    folder.Write("r/" + entry.path().filename().string(), content);
  }
  const ProgramRun run =
      RunProgram({"report", folder.path() / "r", "--out", folder.path() / "p.html"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr(kShown));
  ExpectFitForTerminal(run.out + run.err);
}

/// A folder with a strange name that holds logs of a flight.
class StrangeFolder {
 public:
  explicit StrangeFolder(const std::string& name) : path_(folder_.path() / name) {
    fs::create_directory(path_);
    for (const char* file : {"IMU.txt", "GPS.txt"}) fs::copy(ShortFlight() / file, path_);
  }
  fs::path path() const { return path_; }
  fs::path parent() const { return folder_.path(); }

 private:
  TempFolder folder_;
  fs::path path_;
};

TEST(CliTerminal, ANameOfAFolderReachesItWithoutControlCharacters) {
  const StrangeFolder strange(kControls);
  fs::copy(ShortFlight() / "GPS.txt", strange.path() / kControls);
  const ProgramRun run = RunProgram({"init", strange.path()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr(kShown));
  ExpectFitForTerminal(run.out + run.err);
}

TEST(CliTerminal, LinesOfJsonStayJson) {
  const StrangeFolder strange(std::string(200, 'x') + kControls + "\xc2\x9b\xff");
  const ProgramRun run = RunProgram({"init", strange.path(), "--json-progress"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  ExpectFitForTerminal(run.out + run.err);
  std::istringstream lines(run.err);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count) {
    EXPECT_FALSE(Json::parse(line, nullptr, false).is_discarded()) << line;
  }
  EXPECT_GT(count, 0);
}

TEST(CliTerminal, LettersBeyondAsciiReachIt) {
  std::string name;
  for (int i = 0; i < 40; ++i) name += "\xc3\xbc\xe6\xbc\xa2";
  const StrangeFolder strange(name);
  const ProgramRun run = RunProgram({"init", strange.path()});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("wrote    " + (strange.path() / "flight.yaml").string() + "\n"));
}

TEST(CliTerminal, ACommandToPasteNamesItsFolderAsItIs) {
  for (const char* name : {"my flight", "a'b", "$(touch canary)", "a\nb'\\c"}) {
    const StrangeFolder strange(name);
    const ProgramRun run = RunProgram({"init", strange.path()});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const std::string next = "next     dn check ";
    const std::size_t at = run.out.find(next);
    ASSERT_NE(at, std::string::npos);
    const std::string word =
        run.out.substr(at + next.size(), run.out.find('\n', at) - at - next.size());
    const fs::path script = strange.parent() / "script";
    std::ofstream(script) << "cd " << word << " && touch here\n";
    EXPECT_EQ(std::system(("bash " + script.string()).c_str()), 0) << word;
    EXPECT_TRUE(fs::exists(strange.path() / "here")) << word;
  }
}

}  // namespace dn::testing::apps_test
