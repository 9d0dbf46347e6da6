#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "run_program.h"
#include "static_record.h"
#include "strip_scenario.h"
#include "testing/temp_folder.h"

namespace dn::testing::apps_test {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr const char* kBrowser = "chromium";

bool HasBrowser() {
  return std::system((std::string("command -v ") + kBrowser + " > /dev/null").c_str()) == 0;
}

std::string CaptureOutput(const std::string& command) {
  std::string text;
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) return text;
  char buffer[4096];
  for (std::size_t n = 0; (n = std::fread(buffer, 1, sizeof(buffer), pipe)) > 0;) {
    text.append(buffer, n);
  }
  ::pclose(pipe);
  return text;
}

/// Returns a page that shows another one in a frame of this width, completely, as for printing. Its
/// script then reports figures of the shown page.
std::string Frame(const fs::path& page, int width) {
  return "<!DOCTYPE html><body><iframe style=\"width:" + std::to_string(width) +
         "px;height:30000px;border:0\" src=\"file://" + page.string() + R"("></iframe>
<script>
onload = () => {
  const inside = document.querySelector("iframe").contentWindow;
  const frame = inside.document;
  inside.dispatchEvent(new Event("beforeprint"));
  setTimeout(() => {
    const figures = [...frame.querySelectorAll("figure[data-chart]")];
    const seen = { figures: figures.length, width: frame.documentElement.scrollWidth,
      drawn: figures.filter((figure) => figure.querySelector("svg, canvas")).length };
    document.body.append("SEEN" + JSON.stringify(seen) + "END");
  }, 2000);
};
</script>)";
}

/// Figures of a page as a browser reports them.
struct Seen {
  Json figures;
  std::string console;
};

Seen Show(const fs::path& page, int width) {
  const TempFolder folder;
  folder.Write("frame.html", Frame(fs::absolute(page), width));
  const std::string out = CaptureOutput(
      std::string(kBrowser) +
      " --headless=new --no-sandbox --disable-gpu --enable-logging=stderr "
      "--allow-file-access-from-files --window-size=1400,2000 --virtual-time-budget=8000 "
      "--user-data-dir=" +
      (folder.path() / "profile").string() + " --dump-dom file://" +
      (folder.path() / "frame.html").string() + " 2>" + (folder.path() / "console.txt").string());
  const std::size_t begin = out.rfind("SEEN{") + 4;
  const std::size_t end = out.find("END", begin);
  return {Json::parse(out.substr(begin, end - begin), nullptr, false),
          FileContent(folder.path() / "console.txt")};
}

/// Pages of all commands, made once.
class Browser : public ::testing::TestWithParam<int> {
 protected:
  static void SetUpTestSuite() {
    if (!HasBrowser()) return;
    folder_ = std::make_unique<TempFolder>();
    for (const fs::path& result : {CalibrateResult(), SmoothResult(), GapResult(), CheckResult()}) {
      pages_.push_back(result / "report.html");
    }
    const std::string scenario = ShortScenario().string();
    Make("study", {"study", scenario});
    Make("monte_carlo", {"monte-carlo", scenario, "--flights", "2"});
    Make("blind",
         {"blind-check", "--flights", "1", "--scenarios", scenario, "--gap-options", "screen"});
    folder_->Write("short.yaml", FileContent(ShortScenario()));
    folder_->Write("sweep.yaml", "base: short.yaml\nsweep:\n  pairs.count: [200, 400]\n");
    Make("sweep", {"study", "--sweep", In("sweep.yaml")});
    folder_->Write("IMU.txt", StaticRecord(600));
    Make("allan", {"allan", In("IMU.txt"), "--rate", "50"});
    folder_->Write("town.yaml", StripScenario("kind: built_up, roughness_m: 0.2"));
    Make("flight", {"simulate", In("town.yaml"), "--seed", "2"});
    Make("match", {"match", In("flight"), "--trajectory", In("flight/reference.out")});
    Make("georef", {"georef", In("flight"), "--trajectory", In("flight/reference.out"),
                    "--boresight", "0.2,0.03,0.35"});
    RunProgram(
        {"report", CalibrateResult().string(), SmoothResult().string(), "--out", In("both.html")});
    pages_.push_back(In("both.html"));
  }
  static void TearDownTestSuite() { folder_.reset(); }

  static const std::vector<fs::path>& pages() { return pages_; }

 private:
  static std::string In(const std::string& name) { return (folder_->path() / name).string(); }

  static void Make(const std::string& name, std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--out", In(name)});
    RunProgram(arguments);
    pages_.push_back(fs::path(In(name)) / "report.html");
  }

  static std::unique_ptr<TempFolder> folder_;
  static std::vector<fs::path> pages_;
};

std::unique_ptr<TempFolder> Browser::folder_;
std::vector<fs::path> Browser::pages_;

TEST_P(Browser, DrawsEveryChartWithoutAWordInItsConsole) {
  if (!HasBrowser()) GTEST_SKIP() << kBrowser << " is not installed: no page was looked at";
  for (const fs::path& page : pages()) {
    SCOPED_TRACE(page.string());
    ASSERT_TRUE(fs::exists(page));
    const Seen seen = Show(page, GetParam());
    EXPECT_THAT(seen.console, Not(HasSubstr("CONSOLE")));
    ASSERT_TRUE(seen.figures.is_object());
    EXPECT_EQ(seen.figures["drawn"], seen.figures["figures"]);
    EXPECT_LE(seen.figures["width"], GetParam());  // no horizontal scrolling
  }
}

INSTANTIATE_TEST_SUITE_P(Widths, Browser, ::testing::Values(1280, 400));

}  // namespace dn::testing::apps_test
