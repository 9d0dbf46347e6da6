#include "page_numbers.h"

#include <dn/report/json.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <map>
#include <regex>
#include <string>
#include <vector>

#include "run_program.h"

namespace dn::testing {
namespace {

constexpr std::size_t kMostBytes = 3000000;

/// A number of a page together with the result file and key that it is taken from.
struct Shown {
  double value = 0.0;
  double scale = 1.0;
  std::string file;
  std::string pointer;
  std::string text;
};

std::vector<Shown> ParseShownNumbers(const std::string& html) {
  const std::regex cell(R"re(data-value="([^"]*)" data-scale="([^"]*)" )re"
                        R"re(data-source="([^"#]*)#([^"]*)"[^>]*>([^<]*)</td>)re");
  std::vector<Shown> numbers;
  for (std::sregex_iterator at(html.begin(), html.end(), cell), end; at != end; ++at) {
    numbers.push_back({std::strtod((*at)[1].str().c_str(), nullptr),
                       std::strtod((*at)[2].str().c_str(), nullptr), (*at)[3], (*at)[4], (*at)[5]});
  }
  return numbers;
}

/// Returns half a unit of the last digit of a number in a text, plus a margin for double rounding.
double HalfLastDigit(const std::string& text) {
  const std::size_t exponent = text.find('e');
  const std::string mantissa = text.substr(0, exponent);
  const std::size_t point = mantissa.find('.');
  const double decimals =
      point == std::string::npos ? 0.0 : static_cast<double>(mantissa.size() - point - 1);
  const double power =
      exponent == std::string::npos ? 0.0 : std::strtod(text.c_str() + exponent + 1, nullptr);
  return 0.5000001 * std::pow(10.0, power - decimals);
}

}  // namespace

void ExpectPageMatchesFiles(const std::filesystem::path& folder, std::size_t least) {
  SCOPED_TRACE(folder.string());
  const std::string html = FileContent(folder / "report.html");
  EXPECT_LT(html.size(), kMostBytes);
  std::map<std::string, Json> files;
  const std::vector<Shown> numbers = ParseShownNumbers(html);
  EXPECT_GE(numbers.size(), least);
  for (const Shown& shown : numbers) {
    if (!files.contains(shown.file)) {
      files[shown.file] = Json::parse(FileContent(folder / shown.file));
    }
    const Json::json_pointer pointer(shown.pointer);
    ASSERT_TRUE(files[shown.file].contains(pointer)) << shown.file << shown.pointer;
    EXPECT_EQ(files[shown.file][pointer].get<double>(), shown.value) << shown.pointer;
    EXPECT_NEAR(std::strtod(shown.text.c_str(), nullptr), shown.scale * shown.value,
                HalfLastDigit(shown.text))
        << shown.pointer;
  }
}

}  // namespace dn::testing
