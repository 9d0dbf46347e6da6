#include "serial_blas.h"

#include <dlfcn.h>
#include <sys/mman.h>

#include <mutex>
#include <new>
#include <vector>

extern "C" {
int openblas_get_num_threads(void);
void openblas_set_num_threads(int num_threads);
void* blas_memory_alloc(int position);
void blas_memory_free(void* buffer);
}

namespace dn {
namespace {

// Upper bound of the memory that OpenBLAS maps for each calling thread.
constexpr std::size_t kWorkSpaceBytes = std::size_t{136} << 20;

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
  if (callers <= g_work_spaces) return;
  ExpectRoom(callers);
  std::vector<void*> taken;
  taken.reserve(callers);
  while (taken.size() < callers) taken.push_back(blas_memory_alloc(0));
  for (void* work_space : taken) blas_memory_free(work_space);
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
  g_threads = openblas_get_num_threads();
  openblas_set_num_threads(1);
}

SerialBlas::~SerialBlas() {
  SetOpenMpLevels(openmp_levels_);
  const std::lock_guard lock(g_blas_mutex);
  if (--g_callers == 0) openblas_set_num_threads(g_threads);
}

}  // namespace dn
