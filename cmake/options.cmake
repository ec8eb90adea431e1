# Whole-build switches. Flags live on the interface target `vr_oos_flags`, never in global strings.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

option(VR_OOS_TESTS "Tests, benchmarks and studies; without it, what users run (preset demo)" ON)
option(VR_OOS_RAYS "The viewer that traces rays, with Embree (package libembree-dev; preset demo without)" ON)
option(VR_OOS_PCH "Precompiled headers; without them and without large pieces a missing #include is found (presets dev, fuzz)" ON)
option(VR_OOS_PEERS "FCL, Bullet, OpenVDB and MuJoCo in `oos bench` and slow tests (preset bench, packages of apt-bench.txt)" OFF)
option(VR_OOS_WERROR "Warnings are errors (preset ci)" OFF)
set(VR_OOS_SANITIZE "" CACHE STRING "address,undefined or thread (presets asan, tsan)")

option(VR_OOS_FUZZERS "libFuzzer's executables of tests/fuzz; needs clang (preset fuzz, packages of apt-slow.txt)" OFF)

# ccache caches compilations with precompiled headers only if it may ignore their time stamps.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER env "CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime" "${CCACHE_PROGRAM}")
endif()

# For the project's own targets only: users of an installed library choose their own flags.
add_library(vr_oos_flags INTERFACE)
function(project_compile_options)
  target_compile_options(vr_oos_flags INTERFACE "$<BUILD_INTERFACE:${ARGN}>")
endfunction()
# Results must not depend on the compiler's freedom to fuse a*b+c: runs are compared bit for bit.
project_compile_options(-Wall -Wextra -Wshadow -Wnon-virtual-dtor -ffp-contract=off)
# GCC 12 warns of overlapping and of endless copies inside std::string itself (GCC bugs 105329, 105651).
project_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(VR_OOS_PCH)
  # With a precompiled header it forgets that <string> is a system header, and shows these, too.
  project_compile_options($<$<CXX_COMPILER_ID:GNU>:-Wno-stringop-overflow> $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds>)
endif()
if(VR_OOS_PCH AND CCACHE_PROGRAM AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  project_compile_options(-fpch-preprocess)
endif()
# In a unity build every file is included by another one, so GCC treats it as a header and warns.
if(CMAKE_UNITY_BUILD AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  project_compile_options(-Wno-subobject-linkage)
endif()
# x86-64-v2 (SSE4.2) is the oldest CPU level that can run the 1 kHz loop.
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  project_compile_options(-march=x86-64-v2)
endif()
if(VR_OOS_WERROR)
  project_compile_options(-Werror)
endif()
if(VR_OOS_SANITIZE)
  project_compile_options(-fsanitize=${VR_OOS_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(vr_oos_flags INTERFACE "$<BUILD_INTERFACE:-fsanitize=${VR_OOS_SANITIZE}>")
endif()
if(VR_OOS_FUZZERS)
  project_compile_options(-fsanitize=fuzzer-no-link)
endif()
target_include_directories(vr_oos_flags INTERFACE "$<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}/libs;${CMAKE_SOURCE_DIR}>")
target_compile_features(vr_oos_flags INTERFACE cxx_std_20)
