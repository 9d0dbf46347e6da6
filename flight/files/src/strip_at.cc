#include <dn/files/strip_at.h>

#include <algorithm>

namespace dn {

const StripInterval* StripAt(const std::vector<StripInterval>& strips, double t_s) {
  const auto at = std::find_if(strips.begin(), strips.end(), [&](const StripInterval& strip) {
    return t_s >= strip.t0_s && t_s <= strip.t1_s;
  });
  return at == strips.end() ? nullptr : &*at;
}

std::string StripPairName(const std::vector<StripInterval>& strips, double t_i_s, double t_j_s) {
  return StripPairName(StripAt(strips, t_i_s), StripAt(strips, t_j_s));
}

std::string StripPairName(const StripInterval* i, const StripInterval* j) {
  const auto name = [](const StripInterval* strip) {
    return strip == nullptr ? std::string("?") : strip->name;
  };
  return name(i) + "-" + name(j);
}

}  // namespace dn
