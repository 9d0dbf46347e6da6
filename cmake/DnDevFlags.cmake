# Flags of our own builds only: never exported, never seen by a project that uses dn.
add_library(dn_dev_flags INTERFACE)
target_compile_options(dn_dev_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wno-psabi
  -ffp-contract=off
  $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>  # what a compiler cache needs
  # gcc 12 reports false overlaps and overflows for "text" + std::string (gcc bug 105651), the more
  # with precompiled headers; the address sanitizer finds the true ones.
  "$<$<CXX_COMPILER_ID:GNU>:-Wno-restrict;-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>"
  # Where several sources are one file, gcc takes them for its headers, and what one of them holds
  # outside functions for outer names of all.
  "$<$<AND:$<CXX_COMPILER_ID:GNU>,$<BOOL:${CMAKE_UNITY_BUILD}>>:-Wno-subobject-linkage;-Wno-shadow>"
  $<$<BOOL:${DN_WERROR}>:-Werror>)
if(DN_SANITIZE)
  target_compile_options(dn_dev_flags INTERFACE
    -fsanitize=${DN_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer
    # A quarter of the compile time, for what the address sanitizer stops at anyway, or x86 allows.
    -fno-sanitize=null,alignment,object-size)
  target_link_options(dn_dev_flags INTERFACE -fsanitize=${DN_SANITIZE})
endif()
if(DN_BUILD_FUZZ)
  target_compile_options(dn_dev_flags INTERFACE -fsanitize=fuzzer-no-link)
  target_link_options(dn_dev_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
