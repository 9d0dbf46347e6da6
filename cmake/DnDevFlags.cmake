# Flags for builds of this project only; they are not exported to projects that use dn.
add_library(dn_dev_flags INTERFACE)
target_compile_options(dn_dev_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Woverloaded-virtual -Wno-psabi
  -ffp-contract=off
  $<$<CXX_COMPILER_ID:GNU>:-fpch-preprocess>  # needed by a compiler cache
  # The compiler collects its garbage less often: a sixth less time for a fifth more memory.
  "$<$<CXX_COMPILER_ID:GNU>:SHELL:--param ggc-min-expand=300;SHELL:--param ggc-min-heapsize=1000000>"
  # gcc 12 reports false overlaps and overflows for "text" + std::string (gcc bug 105651), more
  # often with precompiled headers. The address sanitizer finds real ones.
  "$<$<CXX_COMPILER_ID:GNU>:-Wno-restrict;-Wno-array-bounds;-Wno-stringop-overflow;-Wno-stringop-overread>"
  # In a unity build gcc takes the joined sources for headers, in which types that only one of them
  # uses would be a mistake.
  "$<$<AND:$<CXX_COMPILER_ID:GNU>,$<BOOL:${CMAKE_UNITY_BUILD}>>:-Wno-subobject-linkage>"
  $<$<BOOL:${DN_WERROR}>:-Werror>)
if(DN_SANITIZE)
  target_compile_options(dn_dev_flags INTERFACE
    -fsanitize=${DN_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer
    # These checks cost a quarter of the compile time. They find only errors that the address
    # sanitizer also finds or that x86 permits.
    -fno-sanitize=null,alignment,object-size
    $<$<CXX_COMPILER_ID:Clang>:-fsanitize-ignorelist=${CMAKE_CURRENT_LIST_DIR}/undefined_behaviour_ignore.txt>)
  target_link_options(dn_dev_flags INTERFACE -fsanitize=${DN_SANITIZE})
  # The default linker takes a twentieth of the whole build.
  find_program(DN_LLD ld.lld)
  if(DN_LLD)
    target_link_options(dn_dev_flags INTERFACE -fuse-ld=lld)
  endif()
endif()

# Layers with readers. Only their code guides the fuzzer, so that the tests of the other layers run
# at full speed in the same build. These are the flags of -fsanitize=fuzzer-no-link, by themselves
# because clang does not share precompiled headers between sanitizers.
set(DN_FUZZED_LAYERS core geo config report effects imu gnss lidar files sim study fleet montecarlo
  blind_check fuzz_readers)
function(dn_guide_fuzzer layer)
  if(DN_BUILD_FUZZ AND layer IN_LIST DN_FUZZED_LAYERS)
    target_compile_options(dn_${layer} PRIVATE
      -fsanitize-coverage=inline-8bit-counters,pc-table,trace-cmp,indirect-calls)
  endif()
endfunction()
