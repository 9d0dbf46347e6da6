#include <dn/shared_list.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace dn::core_test {

TEST(SharedList, HasTheElementsInTheirOrder) {
  const SharedList<std::string> list{"gyro", "accelerometer"};
  ASSERT_EQ(list.size(), 2U);
  EXPECT_FALSE(list.empty());
  EXPECT_EQ(list[1], "accelerometer");
  EXPECT_EQ(std::vector<std::string>(list.begin(), list.end()),
            (std::vector<std::string>{"gyro", "accelerometer"}));
}

TEST(SharedList, OfNothingIsEmpty) {
  for (const SharedList<int>& list : {SharedList<int>(), SharedList<int>(std::vector<int>())}) {
    EXPECT_TRUE(list.empty());
    EXPECT_EQ(list.begin(), list.end());
  }
}

TEST(SharedList, CopiesShareTheElementsAndOutliveTheirOrigin) {
  SharedList<int> copy;
  const int* elements = nullptr;
  {
    const SharedList<int> list{1, 2, 3};
    copy = list;
    elements = list.begin();
  }
  EXPECT_EQ(copy.begin(), elements);
  EXPECT_EQ(copy[2], 3);
}

}  // namespace dn::core_test
