#include "climb_grid.h"

#include <gtest/gtest.h>

namespace dn::diagnosis_test {

struct Point {
  int x = 0, y = 0;
};

Point Climb(const Point& start, const Point& summit) {
  return diagnosis_internal::ClimbGrid(
      start, {{&Point::x, 5}, {&Point::y, 2}}, [&](const Point& at) {
        return -(at.x - summit.x) * (at.x - summit.x) - (at.y - summit.y) * (at.y - summit.y);
      });
}

TEST(ClimbGrid, ReachesTheSummitFromAnyStart) {
  for (const Point& start : {Point{0, 0}, Point{5, 2}, Point{3, 1}}) {
    const Point top = Climb(start, {3, 1});
    EXPECT_EQ(top.x, 3);
    EXPECT_EQ(top.y, 1);
  }
}

TEST(ClimbGrid, StaysWithinItsBounds) {
  const Point top = Climb({2, 2}, {9, -4});
  EXPECT_EQ(top.x, 5);
  EXPECT_EQ(top.y, 0);
}

}  // namespace dn::diagnosis_test
