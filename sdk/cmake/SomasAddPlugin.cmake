# somas_add_plugin(NAME SOURCES files... [DEPENDS targets...] [OUTPUT_DIRECTORY dir] [NO_INSTALL])
#
# The plugin NAME.somas.so as target NAME. It is written to plugins/ of the build tree, where the
# host of the same build finds it, or to OUTPUT_DIRECTORY, and is installed to lib/somas/plugins
# unless NO_INSTALL is given.
function(somas_add_plugin name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "NO_INSTALL" "OUTPUT_DIRECTORY" "SOURCES;DEPENDS")
  if(NOT arg_SOURCES)
    message(FATAL_ERROR "somas_add_plugin(${name}): SOURCES is missing")
  endif()
  if(arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "somas_add_plugin(${name}): unknown arguments: ${arg_UNPARSED_ARGUMENTS}")
  endif()
  if(NOT arg_OUTPUT_DIRECTORY)
    set(arg_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/plugins")
  endif()

  set(map "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/plugin.map")
  add_library(${name} MODULE ${arg_SOURCES})
  target_link_libraries(${name} PRIVATE Somas::SDK ${arg_DEPENDS})
  if(TARGET somas_flags)
    target_link_libraries(${name} PRIVATE somas_flags)
  endif()
  set_target_properties(${name} PROPERTIES
    PREFIX ""
    SUFFIX ".somas.so"
    CXX_EXTENSIONS OFF
    CXX_VISIBILITY_PRESET hidden
    VISIBILITY_INLINES_HIDDEN ON
    LIBRARY_OUTPUT_DIRECTORY "${arg_OUTPUT_DIRECTORY}"
    LINK_DEPENDS "${map}")

  # Results must not depend on the CPU (no contraction), and a library must be able to unload (gcc
  # marks inline statics unique otherwise).
  target_compile_options(${name} PRIVATE
    -ffp-contract=off $<$<CXX_COMPILER_ID:GNU>:-fno-gnu-unique>)

  # An undefined symbol is an error of the link, not a death at the first call. (Clang's sanitizer
  # runtimes are in the host only, so their symbols have to stay undefined.)
  target_link_options(${name} PRIVATE "LINKER:--version-script=${map}" LINKER:-z,now)
  if(NOT (SOMAS_SANITIZE AND CMAKE_CXX_COMPILER_ID MATCHES "Clang"))
    target_link_options(${name} PRIVATE LINKER:-z,defs)
  endif()

  if(NOT arg_NO_INSTALL)
    install(TARGETS ${name} LIBRARY DESTINATION lib/somas/plugins)
  endif()
endfunction()
