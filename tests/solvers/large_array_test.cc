#include "sparse/large_array.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <thread>
#include <vector>

namespace dn::solvers_test {

constexpr std::size_t kMillion = 1000000;

TEST(ArrayPool, GivesWhatIsDoneWithToTheNext) {
  sparse::ArrayPool pool(2);
  sparse::PooledArray first = pool.New(kMillion);
  const double* place = first.get();
  const sparse::PooledArray beside = pool.New(kMillion);
  EXPECT_NE(beside.get(), place);
  first.reset();
  EXPECT_EQ(pool.New(kMillion + kMillion / 100).get(), place) << "a little larger";
  EXPECT_EQ(pool.New(kMillion - kMillion / 4).get(), place) << "smaller";
}

TEST(ArrayPool, TakesTheSmallestThatFits) {
  sparse::ArrayPool pool(3);
  sparse::PooledArray large = pool.New(2 * kMillion), small = pool.New(kMillion),
                      middle = pool.New(3 * kMillion / 2);
  const double* place = small.get();
  large.reset();
  small.reset();
  middle.reset();
  EXPECT_EQ(pool.New(kMillion).get(), place);
}

TEST(ArrayPool, EveryNumberOfAnArrayIsItsOwn) {
  sparse::ArrayPool pool(2);
  const auto fill = [&pool](std::size_t size, double value) {
    for (int i = 0; i < 40; ++i) {
      const std::size_t n = size + static_cast<std::size_t>(i) * size / 20;
      const sparse::PooledArray array = pool.New(n);
      std::fill_n(array.get(), n, value);
      std::this_thread::yield();
      ASSERT_EQ(std::count(array.get(), array.get() + n, value), static_cast<std::ptrdiff_t>(n));
    }
  };
  std::vector<std::thread> threads;
  for (int k = 0; k < 3; ++k) threads.emplace_back(fill, kMillion / 2, 1.0 + k);
  for (std::thread& thread : threads) thread.join();
}

TEST(ArrayPool, WhatIsSmallOrTooManyIsFreed) {
  sparse::ArrayPool none(0);
  none.New(kMillion).reset();
  sparse::ArrayPool pool(1);
  sparse::PooledArray a = pool.New(kMillion), b = pool.New(2 * kMillion);
  const double* place = b.get();
  a.reset();
  b.reset();
  EXPECT_EQ(pool.New(2 * kMillion).get(), place) << "the larger of the two is kept";
  const sparse::PooledArray tiny = pool.New(3);
  EXPECT_EQ(tiny.get_deleter().pool, nullptr);
}

}  // namespace dn::solvers_test
