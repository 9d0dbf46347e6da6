#include <dlfcn.h>
#include <glog/logging.h>
#include <gtest/gtest.h>

#include <latch>
#include <thread>

#include "quiet_log.h"
#include "sparse/serial_blas.h"

namespace dn::solvers_test {

/// Two threads hold a setting with overlapping lifetimes; the first one also ends first. `look` is
/// called in the main thread while zero, one, one and zero threads hold it.
template <class Setting, class Look>
void Overlap(const Look& look) {
  std::latch first_holds(1), second_holds(1), first_may_end(1), second_may_end(1);
  look(0);
  std::thread first([&] {
    const Setting setting;
    first_holds.count_down();
    first_may_end.wait();
  });
  first_holds.wait();
  look(1);
  std::thread second([&] {
    const Setting setting;
    second_holds.count_down();
    second_may_end.wait();
  });
  second_holds.wait();
  first_may_end.count_down();
  first.join();
  look(1);
  second_may_end.count_down();
  second.join();
  look(0);
}

TEST(ParallelSettings, TheLogIsQuietUntilTheLastThreadHasEnded) {
  FLAGS_minloglevel = google::WARNING;
  Overlap<QuietLog>([](int holders) {
    EXPECT_EQ(FLAGS_minloglevel, holders > 0 ? google::FATAL : google::WARNING);
  });
}

TEST(ParallelSettings, BlasIsSerialUntilTheLastThreadHasEnded) {
  const auto get = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  const auto set = reinterpret_cast<void (*)(int)>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (get == nullptr || set == nullptr) GTEST_SKIP() << "this BLAS has no threads to set";
  set(2);
  Overlap<sparse::SerialBlas>([get](int holders) { EXPECT_EQ(get(), holders > 0 ? 1 : 2); });
}

// CHOLMOD's OpenMP setting is per thread: no thread sees or restores the setting of another.
TEST(ParallelSettings, OpenMpIsSerialInTheThreadsThatAskForIt) {
  const auto levels = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "omp_get_max_active_levels"));
  if (levels == nullptr) GTEST_SKIP() << "CHOLMOD was built without OpenMP";
  const int before = levels();
  ASSERT_GT(before, 0);
  Overlap<sparse::SerialBlas>([&](int) { EXPECT_EQ(levels(), before); });
  {
    const sparse::SerialBlas serial;
    EXPECT_EQ(levels(), 0);
    std::thread([&] {
      { const sparse::SerialBlas other; }
      EXPECT_EQ(levels(), before);
    }).join();
    EXPECT_EQ(levels(), 0);
  }
  EXPECT_EQ(levels(), before);
}

}  // namespace dn::solvers_test
