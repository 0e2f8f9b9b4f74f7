include(GoogleTest)

# semmap_library(NAME [LINK lib...]): a static library of every .cpp in the calling directory.
function(semmap_library name)
  cmake_parse_arguments(ARG "" "" "LINK" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  file(GLOB headers CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.h)
  if(sources)
    add_library(${name} STATIC ${sources} ${headers})
    target_link_libraries(${name} PUBLIC semmap_flags ${ARG_LINK})
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

# semmap_test(NAME [LINK lib...] [LABELS label...] [TIMEOUT s] [PRECOMPILE header...]): one GoogleTest program of every
# *_test.cpp in the calling directory; each test case is a ctest test "NAME/Suite.Case".
function(semmap_test name)
  cmake_parse_arguments(ARG "" "TIMEOUT" "LINK;LABELS;PRECOMPILE" ${ARGN})
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
  list(LENGTH sources files)
  if(files GREATER 3 OR ARG_PRECOMPILE)
    semmap_precompile(test_${name} <gtest/gtest.h> ${ARG_PRECOMPILE})
  endif()
  gtest_discover_tests(test_${name} TEST_PREFIX ${name}/ DISCOVERY_MODE PRE_TEST
    PROPERTIES TIMEOUT ${ARG_TIMEOUT} LABELS "${ARG_LABELS}")
endfunction()
