# The rooms of core/, their tests and their benchmarks. Each function takes its sources from the
# current directory by suffix, so that adding a file needs no change to a CMakeLists.txt.

# somas_add_subdirectories(DIR...)
#
# add_subdirectory for each DIR that has a CMakeLists.txt; one that appears later is noticed by the
# next build.
function(somas_add_subdirectories)
  foreach(dir IN LISTS ARGN)
    file(GLOB list CONFIGURE_DEPENDS "${dir}/CMakeLists.txt")
    if(list)
      add_subdirectory(${dir})
    endif()
  endforeach()
endfunction()

# somas_add_room(NAME [DEPENDS targets...])
#
# Static library somas_NAME from *.cpp here, or an INTERFACE library while there are none.
# Includes are spelt from the repository's root: #include "core/model/world.hpp".
function(somas_add_room name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "DEPENDS")
  file(GLOB sources CONFIGURE_DEPENDS "*.cpp")
  if(sources)
    add_library(somas_${name} STATIC ${sources})
    target_link_libraries(somas_${name} PRIVATE somas_flags PUBLIC ${arg_DEPENDS})
    target_include_directories(somas_${name} PUBLIC "${PROJECT_SOURCE_DIR}")
  else()
    add_library(somas_${name} INTERFACE)
    target_link_libraries(somas_${name} INTERFACE ${arg_DEPENDS})
    target_include_directories(somas_${name} INTERFACE "${PROJECT_SOURCE_DIR}")
  endif()
endfunction()

# somas_mentions_paths(SOURCE RESULT)
#
# Whether a test, or a header of the tests that it includes, mentions SOMAS_SOURCE_DIR or
# SOMAS_BINARY_DIR. The others do without, and so compile to the same object in every checkout; one
# that begins to needs CMake to run again.
function(somas_mentions_paths source result)
  set(mentions "SOMAS_(SOURCE|BINARY)_DIR")
  file(STRINGS "${source}" found REGEX "${mentions}")
  file(STRINGS "${source}" includes REGEX "^#include \"tests/")
  foreach(line IN LISTS includes)
    string(REGEX REPLACE "^#include \"([^\"]*)\".*" "\\1" header "${line}")
    if(EXISTS "${PROJECT_SOURCE_DIR}/${header}")
      file(STRINGS "${PROJECT_SOURCE_DIR}/${header}" in_header REGEX "${mentions}")
      list(APPEND found ${in_header})
    endif()
  endforeach()
  if(found)
    set(${result} ON PARENT_SCOPE)
  else()
    set(${result} OFF PARENT_SCOPE)
  endif()
endfunction()

# somas_add_tests(NAME [DEPENDS targets...])
#
# Executable test_NAME from *_test.cpp here; nothing while there are none. CTest shows its tests
# as NAME/Suite.Test, so `./dev test -R model/` runs a room. Tests find their files through
# SOMAS_SOURCE_DIR and SOMAS_BINARY_DIR (bin/somas-host, plugins/, fixtures/).
function(somas_add_tests name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "DEPENDS")
  file(GLOB sources CONFIGURE_DEPENDS "*_test.cpp")
  if(NOT sources)
    return()
  endif()
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE
    somas_flags ${arg_DEPENDS} rapidcheck rapidcheck_gtest GTest::gmock GTest::gtest_main)
  # What is tested is optimised; the tests themselves need not be, and compile in half the time.
  target_compile_options(test_${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  target_include_directories(test_${name} PRIVATE "${PROJECT_SOURCE_DIR}")
  foreach(source IN LISTS sources)
    somas_mentions_paths("${source}" mentions)
    if(mentions)
      set_property(SOURCE "${source}" APPEND PROPERTY COMPILE_DEFINITIONS
        SOMAS_SOURCE_DIR="${PROJECT_SOURCE_DIR}" SOMAS_BINARY_DIR="${PROJECT_BINARY_DIR}")
    endif()
  endforeach()
  include(GoogleTest)
  gtest_discover_tests(test_${name}
    TEST_PREFIX "${name}/" DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 60 PROPERTIES TIMEOUT 300)
endfunction()

# somas_add_bench(NAME [DEPENDS targets...])
#
# Google Benchmark executable bench/bench_NAME of the build tree from *_bench.cpp here; its main is to
# be added.
function(somas_add_bench name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "DEPENDS")
  file(GLOB sources CONFIGURE_DEPENDS "*_bench.cpp")
  if(NOT sources)
    return()
  endif()
  add_executable(bench_${name} ${sources})
  target_link_libraries(bench_${name} PRIVATE
    somas_flags ${arg_DEPENDS} benchmark::benchmark)
  target_include_directories(bench_${name} PRIVATE "${PROJECT_SOURCE_DIR}")
  target_compile_definitions(bench_${name} PRIVATE
    SOMAS_SOURCE_DIR="${PROJECT_SOURCE_DIR}" SOMAS_BINARY_DIR="${PROJECT_BINARY_DIR}")
  set_target_properties(bench_${name} PROPERTIES
    RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bench")
endfunction()
