#include <dn/parallel.h>
#include <gtest/gtest.h>

#include <future>
#include <stdexcept>
#include <thread>

namespace dn::core_test {

TEST(Beside, OneThreadWorksWhereTheResultIsAskedFor) {
  auto worker = Beside(1, [] { return std::this_thread::get_id(); });
  EXPECT_EQ(worker.get(), std::this_thread::get_id());
}

TEST(Beside, SeveralThreadsWorkWithoutBeingAsked) {
  std::promise<int> sent;
  auto work = Beside(2, [&] { sent.set_value(7); });
  EXPECT_EQ(sent.get_future().get(), 7);
  work.get();
}

TEST(Beside, AnErrorComesWithTheResult) {
  for (const int threads : {1, 2}) {
    auto work = Beside(threads, []() -> int { throw std::runtime_error("no"); });
    EXPECT_THROW(work.get(), std::runtime_error);
  }
}

}  // namespace dn::core_test
