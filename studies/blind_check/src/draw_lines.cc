#include "draw_lines.h"

#include <dn/blind_check/outsider.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>

namespace dn {
namespace {

using Eigen::Vector2d;

constexpr std::size_t kFewestLines = 2;
constexpr std::size_t kMostLinesToCross = 3;

Vector2d Centre(const std::vector<PlannedLine>& lines) {
  Vector2d sum = Vector2d::Zero();
  for (const PlannedLine& line : lines) sum += 0.5 * (line.start_en_m + line.end_en_m);
  return sum / static_cast<double>(lines.size());
}

void Shorten(double share, PlannedLine* line) {
  const Vector2d middle = 0.5 * (line->start_en_m + line->end_en_m);
  line->start_en_m = middle + share * (line->start_en_m - middle);
  line->end_en_m = middle + share * (line->end_en_m - middle);
}

void Turn(const Vector2d& centre, double angle_rad, PlannedLine* line) {
  const Eigen::Rotation2Dd turn(angle_rad);
  line->start_en_m = centre + turn * (line->start_en_m - centre);
  line->end_en_m = centre + turn * (line->end_en_m - centre);
}

/// Returns a strip across the first line, over the centre of all lines.
PlannedLine CrossStrip(const std::vector<PlannedLine>& lines) {
  PlannedLine cross = lines.front();
  const Vector2d half = 0.5 * (cross.end_en_m - cross.start_en_m);
  const Vector2d across(-half.y(), half.x());
  cross.start_en_m = Centre(lines) - across;
  cross.end_en_m = Centre(lines) + across;
  return cross;
}

}  // namespace

void DrawLines(double base_m, Random& random, PlanScenario* plan) {
  std::vector<PlannedLine>& lines = plan->lines;
  const std::size_t most = std::max(lines.size(), kFewestLines);
  const std::size_t kept = kFewestLines + DrawIndex(most - kFewestLines + 1, random);
  if (kept < lines.size()) lines.resize(kept);
  const double share = random.Uniform(0.55, 0.85);
  for (PlannedLine& line : lines) Shorten(share, &line);
  const bool crossed = random.Uniform() < 0.5;
  if (crossed && lines.size() <= kMostLinesToCross) lines.push_back(CrossStrip(lines));
  const double angle_rad = random.Uniform(0.0, 2.0 * std::numbers::pi);
  const Vector2d centre = Centre(lines);
  const double all_higher = random.Uniform(0.92, 1.08);
  for (PlannedLine& line : lines) {
    Turn(centre, angle_rad, &line);
    line.height_m = base_m + all_higher * random.Uniform(1.0, 1.1) * (line.height_m - base_m);
  }
}

}  // namespace dn
