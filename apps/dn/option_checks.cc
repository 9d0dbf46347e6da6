#include "option_checks.h"

#include <dn/names.h>
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>
#include <utility>

#include "shown_text.h"

namespace dn::apps {
namespace {

/// Parses the whole text as a number of type T; a leading '+' is accepted. Returns false if the
/// text is not such a number.
template <class T>
bool ParseAll(std::string_view text, T& value) {
  if (text.size() > 1 && text[0] == '+' && text[1] != '-') text.remove_prefix(1);
  const char* end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, value);
  return result.ec == std::errc() && result.ptr == end;
}

std::string BoundText(std::uint64_t most) {
  return most == std::numeric_limits<std::uint64_t>::max() ? "2^64 - 1" : std::to_string(most);
}

}  // namespace

CLI::Validator PositiveNumber() {
  const auto check = [](const std::string& text) {
    double value = 0.0;
    if (ParseAll(text, value) && value > 0.0 && std::isfinite(value)) return std::string();
    return Quoted(text) + " is not a number above 0";
  };
  return {check, "POSITIVE"};
}

CLI::Validator WholeNumber(std::uint64_t least, std::uint64_t most) {
  const auto check = [least, most](const std::string& text) {
    std::uint64_t value = 0;
    if (ParseAll(text, value) && value >= least && value <= most) return std::string();
    return fmt::format("{} is not an integer from {} to {}", Quoted(text), least, BoundText(most));
  };
  return {check, fmt::format("{} to {}", least, BoundText(most))};
}

CLI::Validator Probability() {
  const auto check = [](const std::string& text) {
    double value = 0.0;
    if (ParseAll(text, value) && value >= 0.0 && value < 1.0) return std::string();
    return Quoted(text) + " is not a number from 0 on, below 1";
  };
  return {check, "0 to 1"};
}

CLI::Validator AllowedValues(std::vector<std::string> words) {
  const std::string all = JoinNames(words);
  const auto check = [words = std::move(words), all](const std::string& text) {
    if (std::find(words.begin(), words.end(), text) != words.end()) return std::string();
    return Quoted(text) + " is not one of " + all;
  };
  return {check, "one of " + all};
}

}  // namespace dn::apps
