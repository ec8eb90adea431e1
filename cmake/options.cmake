# Whole-build switches. Flags live on the interface target `vr_oos_flags`, never in global strings.
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

option(VR_OOS_TESTS "Tests, benchmarks and studies; without it, what users run (preset demo)" ON)
option(VR_OOS_PCH "Precompiled headers; without them a missing #include is found (presets dev, asan, tsan, fuzz)" ON)
option(VR_OOS_PEERS "FCL, Bullet, OpenVDB and MuJoCo in `oos bench` and slow tests (preset bench, packages of apt-bench.txt)" OFF)
option(VR_OOS_WERROR "Warnings are errors (preset ci)" OFF)
set(VR_OOS_SANITIZE "" CACHE STRING "address,undefined or thread (presets asan, tsan)")

option(VR_OOS_FUZZERS "libFuzzer's executables of tests/fuzz; needs clang (preset fuzz, packages of apt-slow.txt)" OFF)

# ccache takes precompiled headers only when it need not compare their times.
find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  set(CMAKE_CXX_COMPILER_LAUNCHER env "CCACHE_SLOPPINESS=pch_defines,time_macros,include_file_mtime,include_file_ctime" "${CCACHE_PROGRAM}")
endif()

add_library(vr_oos_flags INTERFACE)
# Results must not depend on the compiler's freedom to fuse a*b+c: runs are compared bit for bit.
target_compile_options(vr_oos_flags INTERFACE -Wall -Wextra -Wshadow -Wnon-virtual-dtor -ffp-contract=off)
# GCC 12 warns of overlapping copies inside std::string itself (GCC bug 105329).
target_compile_options(vr_oos_flags INTERFACE $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict>)
if(VR_OOS_PCH AND CCACHE_PROGRAM AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(vr_oos_flags INTERFACE -fpch-preprocess)
endif()
# x86-64-v2 (SSE4.2) is the oldest CPU that Debian 12's users of a 1 kHz loop have.
if(CMAKE_SYSTEM_PROCESSOR STREQUAL "x86_64")
  target_compile_options(vr_oos_flags INTERFACE -march=x86-64-v2)
endif()
if(VR_OOS_WERROR)
  target_compile_options(vr_oos_flags INTERFACE -Werror)
endif()
if(VR_OOS_SANITIZE)
  target_compile_options(vr_oos_flags INTERFACE -fsanitize=${VR_OOS_SANITIZE} -fno-omit-frame-pointer -fno-sanitize-recover=all)
  target_link_options(vr_oos_flags INTERFACE -fsanitize=${VR_OOS_SANITIZE})
endif()
if(VR_OOS_FUZZERS)
  target_compile_options(vr_oos_flags INTERFACE -fsanitize=fuzzer-no-link)
endif()
target_include_directories(vr_oos_flags INTERFACE "${CMAKE_SOURCE_DIR}/libs" "${CMAKE_SOURCE_DIR}")
