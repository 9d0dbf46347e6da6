# dn_embed_files(<layer> OUTPUT <file.cc> FILES <name> <file> ...)
#
# Generates a source that contains each file as the string_view dn::<layer>_internal::<name>, and
# adds it to the library of the layer. Run as a script (cmake -P), this file writes that source.
if(CMAKE_SCRIPT_MODE_FILE)
  set(text "#include <string_view>\n\nnamespace dn::${LAYER}_internal {\n\n")
  while(FILES)
    list(POP_FRONT FILES name file)
    file(READ ${file} bytes HEX)
    string(REGEX REPLACE "(..)" "0x\\1," bytes "${bytes}")
    string(APPEND text
      "namespace {\n"
      "const unsigned char ${name}_bytes[] = {${bytes}};\n"
      "}  // namespace\n"
      "extern const std::string_view ${name};\n"
      "const std::string_view ${name}(\n"
      "    reinterpret_cast<const char*>(${name}_bytes), sizeof(${name}_bytes));\n\n")
  endwhile()
  file(WRITE ${OUTPUT} "${text}}  // namespace dn::${LAYER}_internal\n")
  return()
endif()

set(DN_EMBED_SCRIPT ${CMAKE_CURRENT_LIST_FILE})

function(dn_embed_files layer)
  cmake_parse_arguments(A "" "OUTPUT" "FILES" ${ARGN})
  set(list ${A_FILES})
  while(list)
    list(POP_FRONT list name file)
    list(APPEND depends ${file})
  endwhile()
  set(output ${CMAKE_CURRENT_BINARY_DIR}/${A_OUTPUT})
  add_custom_command(OUTPUT ${output}
    COMMAND ${CMAKE_COMMAND} "-DLAYER=${layer}" "-DOUTPUT=${output}" "-DFILES=${A_FILES}" -P ${DN_EMBED_SCRIPT}
    DEPENDS ${depends} ${DN_EMBED_SCRIPT} VERBATIM)
  target_sources(dn_${layer} PRIVATE ${output})
  set_source_files_properties(${output} PROPERTIES
    SKIP_PRECOMPILE_HEADERS ON SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()
