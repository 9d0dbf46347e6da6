#include "sparse/serial_blas.h"

#include <dlfcn.h>
#include <sys/mman.h>

#include <mutex>
#include <new>
#include <vector>

namespace dn::sparse {
namespace {

// Upper bound of the memory that OpenBLAS maps for each calling thread.
constexpr std::size_t kWorkSpaceBytes = std::size_t{136} << 20;

/// Functions of OpenBLAS that are not part of BLAS; all null if another BLAS is linked. They are
/// looked up at run time, so that every BLAS links.
struct OpenBlas {
  int (*get_num_threads)();
  void (*set_num_threads)(int num_threads);
  void* (*memory_alloc)(int position);
  void (*memory_free)(void* buffer);
};

template <class Function>
void Look(const char* symbol, Function* function) {
  *function = reinterpret_cast<Function>(::dlsym(RTLD_DEFAULT, symbol));
}

OpenBlas FindOpenBlas() {
  OpenBlas found{};
  Look("openblas_get_num_threads", &found.get_num_threads);
  Look("openblas_set_num_threads", &found.set_num_threads);
  Look("blas_memory_alloc", &found.memory_alloc);
  Look("blas_memory_free", &found.memory_free);
  return found;
}

const OpenBlas& TheOpenBlas() {
  static const OpenBlas found = FindOpenBlas();
  return found;
}

int NumBlasThreads() {
  return TheOpenBlas().get_num_threads == nullptr ? 1 : TheOpenBlas().get_num_threads();
}

void SetNumBlasThreads(int threads) {
  if (TheOpenBlas().set_num_threads != nullptr) TheOpenBlas().set_num_threads(threads);
}

std::mutex g_blas_mutex;
std::size_t g_callers = 0;
int g_threads = 1;  // before the first caller
// Number of workspaces that OpenBLAS owns and reuses between callers.
std::size_t g_work_spaces = 0;

void ExpectRoom(std::size_t work_spaces) {
  const std::size_t bytes = work_spaces * kWorkSpaceBytes;
  void* room =
      ::mmap(nullptr, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
  if (room == MAP_FAILED) throw std::bad_alloc();
  ::munmap(room, bytes);
}

/// Makes OpenBLAS allocate a workspace for each caller in advance, while there is memory.
void ReserveWorkSpaces(std::size_t callers) {
  const OpenBlas& blas = TheOpenBlas();
  if (callers <= g_work_spaces || blas.memory_alloc == nullptr || blas.memory_free == nullptr)
    return;
  ExpectRoom(callers);
  std::vector<void*> taken;
  taken.reserve(callers);
  while (taken.size() < callers) taken.push_back(blas.memory_alloc(0));
  for (void* work_space : taken) blas.memory_free(work_space);
  g_work_spaces = callers;
}

// Returns and sets the number of nested parallel levels in the OpenMP library of CHOLMOD, if any.
int OpenMpLevels() {
  static const auto get =
      reinterpret_cast<int (*)()>(::dlsym(RTLD_DEFAULT, "omp_get_max_active_levels"));
  return get == nullptr ? 0 : get();
}

void SetOpenMpLevels(int levels) {
  static const auto set =
      reinterpret_cast<void (*)(int)>(::dlsym(RTLD_DEFAULT, "omp_set_max_active_levels"));
  if (set != nullptr) set(levels);
}

}  // namespace

SerialBlas::SerialBlas() : openmp_levels_(OpenMpLevels()) {
  const std::lock_guard lock(g_blas_mutex);
  ReserveWorkSpaces(g_callers + 1);
  SetOpenMpLevels(0);
  if (g_callers++ > 0) return;
  g_threads = NumBlasThreads();
  SetNumBlasThreads(1);
}

SerialBlas::~SerialBlas() {
  SetOpenMpLevels(openmp_levels_);
  const std::lock_guard lock(g_blas_mutex);
  if (--g_callers == 0) SetNumBlasThreads(g_threads);
}

}  // namespace dn::sparse
