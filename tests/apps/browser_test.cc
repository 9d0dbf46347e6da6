#include <dn/report/json.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "run_program.h"
#include "testing/temp_folder.h"

namespace dn::testing {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

constexpr const char* kBrowser = "chromium";
constexpr double kMostDrawingMs = 1000.0;

bool HasBrowser() {
  return std::system((std::string("command -v ") + kBrowser + " > /dev/null").c_str()) == 0;
}

std::string OutputOf(const std::string& command) {
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

/// A page that shows another in a frame of the width, all of it as for a printer, and says what it
/// then sees.
std::string Frame(const fs::path& page, int width) {
  return "<!DOCTYPE html><body><iframe style=\"width:" + std::to_string(width) +
         "px;height:30000px;border:0\" src=\"file://" + page.string() + R"("></iframe>
<script>
const start = performance.now();
onload = () => {
  const inside = document.querySelector("iframe").contentWindow;
  const frame = inside.document;
  const loaded = performance.now() - start;
  inside.dispatchEvent(new Event("beforeprint"));
  setTimeout(() => {
    const figures = [...frame.querySelectorAll("figure[data-chart]")];
    const seen = { figures: figures.length, loaded_ms: loaded, width: frame.documentElement.scrollWidth,
      drawn: figures.filter((figure) => figure.querySelector("svg, canvas")).length };
    document.body.append("SEEN" + JSON.stringify(seen) + "END");
  }, 2000);
};
</script>)";
}

/// What a browser sees of a page.
struct Seen {
  Json figures;
  std::string console;
};

Seen Show(const fs::path& page, int width) {
  const TempFolder folder;
  folder.Write("frame.html", Frame(fs::absolute(page), width));
  const std::string out = OutputOf(
      std::string(kBrowser) +
      " --headless=new --no-sandbox --disable-gpu --enable-logging=stderr "
      "--allow-file-access-from-files --window-size=1400,2000 --virtual-time-budget=8000 "
      "--user-data-dir=" +
      (folder.path() / "profile").string() + " --dump-dom file://" +
      (folder.path() / "frame.html").string() + " 2>" + (folder.path() / "console.txt").string());
  const std::size_t begin = out.rfind("SEEN{") + 4;
  const std::size_t end = out.find("END", begin);
  return {Json::parse(out.substr(begin, end - begin), nullptr, false),
          ContentOf(folder.path() / "console.txt")};
}

class Browser : public ::testing::TestWithParam<int> {};

TEST_P(Browser, DrawsEveryChartWithoutAWordInItsConsole) {
  if (!HasBrowser()) GTEST_SKIP() << kBrowser << " is not installed: no page was looked at";
  for (const fs::path& result : {CalibrateResult(), SmoothResult(), GapResult(), CheckResult()}) {
    SCOPED_TRACE(result.string());
    const Seen seen = Show(result / "report.html", GetParam());
    EXPECT_THAT(seen.console, Not(HasSubstr("CONSOLE")));
    ASSERT_TRUE(seen.figures.is_object());
    EXPECT_EQ(seen.figures["drawn"], seen.figures["figures"]);
    EXPECT_LE(seen.figures["width"], GetParam());  // nothing makes one scroll sideways
    EXPECT_LT(seen.figures["loaded_ms"], kMostDrawingMs);
  }
}

INSTANTIATE_TEST_SUITE_P(Widths, Browser, ::testing::Values(1280, 400));

}  // namespace
}  // namespace dn::testing
