option(SEMMAP_BUILD_TESTS "Build the tests and benchmarks" ON)
option(SEMMAP_UNITY "Compile several files at once: a whole build takes a fifth of the time, a small change longer" OFF)
set(SEMMAP_MARCH "" CACHE STRING "Value of -march for our code; empty: the compiler's default")
set(SEMMAP_SANITIZE "" CACHE STRING "Comma-separated list for -fsanitize")

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  # The sloppiness lets ccache serve translation units that use a precompiled header.
  set(CMAKE_CXX_COMPILER_LAUNCHER
      ${CMAKE_COMMAND} -E env CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime
      ${CCACHE_PROGRAM})
endif()

# Flags of our own code; third-party headers come in as SYSTEM and are not subject to the warnings.
add_library(semmap_flags INTERFACE)
target_compile_options(semmap_flags INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion -Wnon-virtual-dtor -Woverloaded-virtual -Werror
  -fpch-preprocess)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  # GCC 12's AVX-512 intrinsics initialize "undefined" registers with themselves and then warn about it
  # wherever Eigen inlines them (GCC bug 105593). With AVX it takes Eigen's four-double loads, which a 3-vector never
  # reaches, for reads beyond its 24 bytes: which files that hits depends on the CPU built for.
  target_compile_options(semmap_flags INTERFACE -Wno-maybe-uninitialized -Wno-uninitialized -Wno-array-bounds)
endif()
# Debian builds Ceres for the baseline CPU: with a wider -march Eigen would align its types to 32 or
# 64 bytes in our code and to 16 in Ceres. Fixing the alignment keeps one layout on both sides.
target_compile_definitions(semmap_flags INTERFACE EIGEN_MAX_ALIGN_BYTES=16)
target_include_directories(semmap_flags INTERFACE ${PROJECT_SOURCE_DIR})
if(SEMMAP_MARCH)
  target_compile_options(semmap_flags INTERFACE -march=${SEMMAP_MARCH})
endif()
if(SEMMAP_SANITIZE)
  target_compile_options(semmap_flags INTERFACE -fsanitize=${SEMMAP_SANITIZE} -fno-sanitize-recover=all)
  target_link_options(semmap_flags INTERFACE -fsanitize=${SEMMAP_SANITIZE})
endif()
