#include <dn/report/value_words.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

constexpr int kMostDecimals = 15;

/// Formats a number with this many decimals, without zeros at their end.
std::string Fixed(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (decimals > 0) text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text == "-0" ? "0" : text;
}

}  // namespace

std::string FormatWithSigma(double value, double sigma, const char* plus_minus) {
  if (!std::isfinite(value) || !std::isfinite(sigma) || !(sigma > 0.0)) {
    return fmt::format("{:.10g} {} {:.2g}", value, plus_minus, sigma);
  }
  const int digit = static_cast<int>(std::floor(std::log10(sigma))) - 1;
  const double last = std::pow(10.0, digit);
  const int decimals = std::clamp(-digit, 0, kMostDecimals);
  return fmt::format("{} {} {}", Fixed(last * std::round(value / last), decimals), plus_minus,
                     Fixed(last * std::round(sigma / last), decimals));
}

}  // namespace dn
