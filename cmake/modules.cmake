include(GoogleTest)

# semmap_unite(TARGET [APART file...]): with SEMMAP_UNITY, compiles the target's files eight at a time, so that
# headers, which are most of the work, are read once for eight files. Names in anonymous namespaces then meet: what
# two files need belongs into a header, other names say more of what they are, and files for which neither makes
# sense stay apart.
function(semmap_unite target)
  cmake_parse_arguments(ARG "" "" "APART" ${ARGN})
  if(SEMMAP_UNITY)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 8)
    set_source_files_properties(${ARG_APART} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()

# semmap_library(NAME [LINK lib...] [APART file...] [ALL_APART]): a static library of every .cpp in the calling
# directory; APART and ALL_APART: not to be united with others (see semmap_unite).
function(semmap_library name)
  cmake_parse_arguments(ARG "ALL_APART" "" "LINK;APART" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  file(GLOB headers CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.h)
  if(sources)
    add_library(${name} STATIC ${sources} ${headers})
    target_link_libraries(${name} PUBLIC semmap_flags ${ARG_LINK})
    if(NOT ARG_ALL_APART)
      semmap_unite(${name} APART ${ARG_APART})
    endif()
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE semmap_flags ${ARG_LINK})
  endif()
endfunction()

# semmap_precompile(TARGET header...): compiles third-party and generated headers once for the target; generated
# ones are named as "<semmap/v1/map.pb.h>". Only headers of others: a precompiled header is included before every
# file, so one of ours would hide that a file does not include what it uses. Configure with
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON to see that all do; deploy/tidy.sh reads the sources that way.
function(semmap_precompile target)
  target_precompile_headers(${target} PRIVATE ${ARGN})
endfunction()

# semmap_test(NAME [LINK lib...] [LABELS label...] [TIMEOUT s] [PRECOMPILE header...] [APART file...] [ALL_APART]): one
# GoogleTest program of every *_test.cpp in the calling directory; each test case is a ctest test
# "NAME/Suite.Case".
function(semmap_test name)
  cmake_parse_arguments(ARG "ALL_APART" "TIMEOUT" "LINK;LABELS;PRECOMPILE;APART" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*_test.cpp)
  if(NOT sources)
    return()
  endif()
  if(NOT ARG_TIMEOUT)
    set(ARG_TIMEOUT 300)
  endif()
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE semmap_flags ${ARG_LINK} GTest::gmock GTest::gtest_main)
  target_compile_definitions(test_${name} PRIVATE SEMMAP_SOURCE_DIR="${PROJECT_SOURCE_DIR}")
  if(NOT ARG_ALL_APART)
    semmap_unite(test_${name} APART ${ARG_APART})
  endif()
  list(LENGTH sources files)
  if(files GREATER 3 OR ARG_PRECOMPILE)
    semmap_precompile(test_${name} <gtest/gtest.h> ${ARG_PRECOMPILE})
  endif()
  # The first start of a program that links libtorch reads it from disk.
  gtest_discover_tests(test_${name} TEST_PREFIX ${name}/ DISCOVERY_MODE PRE_TEST DISCOVERY_TIMEOUT 120
    PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}")
endfunction()
