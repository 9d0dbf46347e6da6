#include "false_returns.h"

#include <dn/lidar/strip_cloud.h>

#include <algorithm>
#include <cmath>

namespace dn {
namespace {

constexpr std::uint8_t kLowNoise = 7, kHighNoise = 18;
constexpr double kInTheAir = 0.7;
constexpr double kDeepest_m = 20.0;
constexpr std::uint16_t kFaint = 20;
// Intensity of a white surface below the scanner.
constexpr double kWhite = 4000.0;
constexpr double kBrightest = 65535.0;

}  // namespace

Return MakeReturn(const Echo& echo, double height_m) {
  const double near = height_m / echo.range_m;
  const double intensity = std::min(kBrightest, std::round(kWhite * echo.energy * near * near));
  return {echo.range_m, static_cast<std::uint16_t>(intensity), PointClass(echo.surface)};
}

void AddFalseReturn(double height_m, Random* random, std::vector<Return>* returns) {
  Return noise;
  noise.intensity = kFaint;
  const bool in_the_air = random->Uniform() < kInTheAir;
  if (random->Uniform() < 0.5) noise.flags = StripCloud::kWithheld;
  const double share = random->Uniform();
  if (in_the_air) {
    noise.point_class = kHighNoise;
    const double first_m = returns->empty() ? height_m : returns->front().range_m;
    noise.range_m = first_m * (0.2 + 0.79 * share);
    returns->insert(returns->begin(), noise);
    return;
  }
  noise.point_class = kLowNoise;
  const double last_m = returns->empty() ? height_m : returns->back().range_m;
  noise.range_m = last_m + 1.0 + (kDeepest_m - 1.0) * share;
  returns->push_back(noise);
}

}  // namespace dn
