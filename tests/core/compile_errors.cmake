# The tests <layer>.compile_errors: the compiler must reject every file of compile_errors/ with the text of
# its first line, "// says: ...". The same file must compile without its line marked "// wrong", which
# shows that this line is the one rejected.
file(GLOB cases ${CASES}/*.cc)
set(scratch ${CMAKE_CURRENT_BINARY_DIR}/compile_errors)
list(TRANSFORM INCLUDES PREPEND -I)
foreach(case IN LISTS cases)
  get_filename_component(name ${case} NAME_WE)
  file(READ ${case} text)
  string(REGEX MATCH "^// says: ([^\n]*)" first_line "${text}")
  set(expected "${CMAKE_MATCH_1}")
  string(REGEX REPLACE "[^\n]*// wrong\n" "" right "${text}")
  file(WRITE ${scratch}/${name}_right.cc "${right}")
  foreach(source IN ITEMS ${case} ${scratch}/${name}_right.cc)
    execute_process(
      COMMAND ${CXX_COMPILER} -std=c++20 -fsyntax-only ${INCLUDES} -isystem ${EIGEN} ${source}
      RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
    if(source STREQUAL case)
      string(FIND "${output}" "${expected}" at)
      if(result EQUAL 0 OR at EQUAL -1)
        message(SEND_ERROR "${name}: expected an error that says: ${expected}\n${output}")
      endif()
    elseif(NOT result EQUAL 0)
      message(SEND_ERROR "${name} without its wrong line does not compile:\n${output}")
    endif()
  endforeach()
endforeach()
