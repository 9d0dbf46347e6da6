// libFuzzer's entry to the readers. See CMakeLists.txt.
#include <cstddef>
#include <cstdint>

#include "read_anything.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  dn::testing::ReadAnything(data, size);
  return 0;
}
