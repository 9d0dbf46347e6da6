#include <dlfcn.h>
#include <dn/solvers/marginals.h>
#include <gtest/gtest.h>

#include <string>

#include "solvers/pose_graph.h"

namespace dn::solvers_test {

/// Returns the shared library from which this process takes a function.
std::string FindLibrary(const char* function) {
  void* address = dlsym(RTLD_DEFAULT, function);
  Dl_info info{};
  if (address == nullptr || dladdr(address, &info) == 0) return "";
  return info.dli_fname;
}

// Debian's Ceres pulls in ATLAS, with which CHOLMOD is about twice as slow.
TEST(Blas, CholmodsKernelsComeFromTheChosenLibrary) {
  for (const char* function : {"dgemm_", "dsyrk_", "dtrsm_", "dsymm_"}) {
    EXPECT_NE(FindLibrary(function).find(DN_BLAS_NAME), std::string::npos)
        << function << " is found in '" << FindLibrary(function) << "'";
  }
}

TEST(Blas, ThreadCountIsGivenBack) {
  using Get = int (*)();
  using Set = void (*)(int);
  const auto get = reinterpret_cast<Get>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  const auto set = reinterpret_cast<Set>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (get == nullptr || set == nullptr) GTEST_SKIP() << "this BLAS has no threads to set";
  set(2);
  const int before = get();
  testing::PoseGraph graph = testing::MakePoseGraph(0);
  EXPECT_GT(Marginals(graph.network).Covariance(graph.q_bs)(0, 0), 0.0);
  EXPECT_EQ(get(), before);
}

}  // namespace dn::solvers_test
