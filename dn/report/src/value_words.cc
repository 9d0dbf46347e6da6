#include <dn/report/value_words.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

constexpr int kMostDecimals = 15;

/// Formats a number with this many decimals, without the sign of a zero.
std::string Fixed(double value, int decimals) {
  std::string text = fmt::format("{:.{}f}", value, decimals);
  if (text.find_first_not_of("-0.") == std::string::npos && text[0] == '-') text.erase(0, 1);
  return text;
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
