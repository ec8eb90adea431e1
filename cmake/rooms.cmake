# A room is a folder with sources beside their tests. add_room and add_node are all that its CMakeLists.txt needs.
#
# Files: *_test.cpp become one GoogleTest executable per room, *_slow_test.cpp and *_realtime_test.cpp one each with that
# label, *_bench.cpp one Google Benchmark executable, main.cpp the node's executable; everything else is the library.
# What only tests and benchmarks need lies in the room's folder testing/ and becomes the library <room>_testing, which
# links the room. The room's own tests link it; others name it in TEST_DEPS. check_shipped.cmake keeps it out of programs.
# A folder inside with a CMakeLists.txt of its own is another room.

# Sanitizers make the tests some five times slower.
set(VR_OOS_TEST_SECONDS 300)
if(VR_OOS_SANITIZE)
  math(EXPR VR_OOS_TEST_SECONDS "5 * ${VR_OOS_TEST_SECONDS}")
endif()

# add_room_library(<name> <deps> <sources>...): without sources it is a library of headers.
function(add_room_library name deps)
  if(ARGN)
    add_library(${name} STATIC ${ARGN})
    target_link_libraries(${name} PUBLIC ${deps})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE ${deps})
  endif()
endfunction()

function(add_test_group name room label seconds deps)
  if(ARGN)
    add_executable(${name}_test ${ARGN})
    target_link_libraries(${name}_test PRIVATE ${room} GTest::gtest GTest::gmock GTest::gtest_main ${deps})
    target_compile_definitions(${name}_test PRIVATE VR_OOS_SOURCE_DIR="${CMAKE_SOURCE_DIR}" VR_OOS_BINARY_DIR="${CMAKE_BINARY_DIR}")
    add_test(NAME ${name} COMMAND ${name}_test)
    set_tests_properties(${name} PROPERTIES LABELS ${label} TIMEOUT ${seconds})
  endif()
endfunction()

# add_room(<name> [DEPS <targets>...] [TEST_DEPS <targets>...] [TEST_LABEL <label>])
function(add_room name)
  cmake_parse_arguments(ROOM "" "TEST_LABEL" "DEPS;TEST_DEPS" ${ARGN})
  set(here "${CMAKE_CURRENT_SOURCE_DIR}")
  file(GLOB_RECURSE sources CONFIGURE_DEPENDS RELATIVE "${here}" "${here}/*.cpp")
  file(GLOB_RECURSE rooms_inside RELATIVE "${here}" "${here}/*/CMakeLists.txt")
  foreach(inside ${rooms_inside})
    get_filename_component(inside "${inside}" DIRECTORY)
    list(FILTER sources EXCLUDE REGEX "^${inside}/")
  endforeach()
  set(tests ${sources})
  set(benches ${sources})
  list(FILTER sources EXCLUDE REGEX "(_test|_bench|(^|/)main)\\.cpp$")
  set(testing ${sources})
  list(FILTER testing INCLUDE REGEX "^testing/")
  list(FILTER sources EXCLUDE REGEX "^testing/")
  list(FILTER benches INCLUDE REGEX "_bench\\.cpp$")
  list(FILTER tests INCLUDE REGEX "_test\\.cpp$")
  set(slow_tests ${tests})
  set(realtime_tests ${tests})
  list(FILTER slow_tests INCLUDE REGEX "_slow_test\\.cpp$")
  list(FILTER realtime_tests INCLUDE REGEX "_realtime_test\\.cpp$")
  list(FILTER tests EXCLUDE REGEX "_(slow|realtime)_test\\.cpp$")

  add_room_library(${name} "vr_oos_flags;${ROOM_DEPS}" ${sources})
  if(IS_DIRECTORY "${here}/testing")
    add_room_library(${name}_testing ${name} ${testing})
    list(APPEND ROOM_TEST_DEPS ${name}_testing)
  endif()

  set(label unit)
  if(ROOM_TEST_LABEL)
    set(label ${ROOM_TEST_LABEL})
  endif()
  add_test_group(${name} ${name} ${label} ${VR_OOS_TEST_SECONDS} "${ROOM_TEST_DEPS}" ${tests})
  add_test_group(${name}_slow ${name} slow 3600 "${ROOM_TEST_DEPS}" ${slow_tests})
  add_test_group(${name}_realtime ${name} realtime ${VR_OOS_TEST_SECONDS} "${ROOM_TEST_DEPS}" ${realtime_tests})
  if(benches)
    add_executable(${name}_bench ${benches})
    target_link_libraries(${name}_bench PRIVATE ${name} benchmark::benchmark_main ${ROOM_TEST_DEPS})
    target_compile_definitions(${name}_bench PRIVATE VR_OOS_SOURCE_DIR="${CMAKE_SOURCE_DIR}")
  endif()
endfunction()

# add_node(<name> DEPS ...): a room called <name>_lib plus the executable <name> from main.cpp, in build/bin.
function(add_node name)
  add_room(${name}_lib ${ARGN})
  if(EXISTS "${CMAKE_CURRENT_SOURCE_DIR}/main.cpp")
    add_executable(${name} main.cpp)
    target_link_libraries(${name} PRIVATE ${name}_lib)
    set_target_properties(${name} PROPERTIES RUNTIME_OUTPUT_DIRECTORY "${CMAKE_BINARY_DIR}/bin")
  endif()
endfunction()
