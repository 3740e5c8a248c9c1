# Everything SOMAS needs from outside, with the lowest version each part is known to work with.
# The Debian packages that provide it are listed in cmake/debian-packages.txt; `./dev build`
# installs them. Imported targets count as SYSTEM, so our warnings stop at their headers.

find_package(Threads REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)   # Eigen3::Eigen
find_package(yaml-cpp 0.7 REQUIRED)           # yaml-cpp
find_package(fmt 9.1 REQUIRED)                # fmt::fmt
find_package(spdlog 1.10 REQUIRED)            # spdlog::spdlog, the compiled library
find_package(CLI11 2.1 REQUIRED)              # CLI11::CLI11
find_package(nlohmann_json 3.11 REQUIRED)     # nlohmann_json::nlohmann_json

# Boost.DLL, header only: with std::filesystem it needs no compiled Boost library.
find_package(Boost 1.74 REQUIRED)
add_library(somas_boost_dll INTERFACE)
target_link_libraries(somas_boost_dll INTERFACE Boost::headers ${CMAKE_DL_LIBS})
target_compile_definitions(somas_boost_dll INTERFACE BOOST_DLL_USE_STD_FS)

find_package(SQLite3 3.40 REQUIRED)           # SQLite::SQLite3, the store of a run

# xxHash has no CMake package. The library is linked for users that do not set XXH_INLINE_ALL.
find_path(XXHASH_INCLUDE_DIR xxhash.h REQUIRED)
find_library(XXHASH_LIBRARY xxhash REQUIRED)
add_library(xxHash::xxhash UNKNOWN IMPORTED GLOBAL)
set_target_properties(xxHash::xxhash PROPERTIES
  IMPORTED_LOCATION "${XXHASH_LIBRARY}"
  INTERFACE_INCLUDE_DIRECTORIES "${XXHASH_INCLUDE_DIR}")

# cairo comes with a pkg-config file only. Pictures are drawn with it.
find_package(PkgConfig REQUIRED)
pkg_check_modules(cairo REQUIRED IMPORTED_TARGET GLOBAL cairo>=1.16)   # PkgConfig::cairo

find_package(ZLIB 1.2 REQUIRED)               # ZLIB::ZLIB; replay pages hold gzip
# Recordings are HDF5 files, written through its C library (the serial one).
pkg_check_modules(hdf5 REQUIRED IMPORTED_TARGET GLOBAL hdf5>=1.10.7)     # PkgConfig::hdf5
pkg_check_modules(libdeflate REQUIRED IMPORTED_TARGET GLOBAL libdeflate>=1.14)  # compresses them

if(SOMAS_BUILD_TESTS)
  find_package(GTest 1.12 REQUIRED)           # GTest::gtest_main, GTest::gmock
  find_package(rapidcheck REQUIRED)           # rapidcheck, rapidcheck_gtest: property tests

  # The reference our own Philox is tested against; headers only, no CMake package.
  find_path(RANDOM123_INCLUDE_DIR Random123/philox.h REQUIRED)
  add_library(Random123::Random123 INTERFACE IMPORTED GLOBAL)
  set_target_properties(Random123::Random123 PROPERTIES
    INTERFACE_INCLUDE_DIRECTORIES "${RANDOM123_INCLUDE_DIR}")
endif()

find_package(benchmark 1.7 QUIET)             # benchmark::benchmark_main, optional
