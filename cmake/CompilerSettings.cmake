# Warnings, sanitizers, clang-tidy and ccache, the same for every target of the project.
option(FLUXGS_SANITIZE "Build with AddressSanitizer and UndefinedBehaviorSanitizer" OFF)
option(FLUXGS_FUZZ "Build the fuzz targets (clang), with the sanitizers" OFF)
option(FLUXGS_WARNINGS_AS_ERRORS "Off for compilers that we have not tried" ON)
option(FLUXGS_TIDY "Run clang-tidy on every file while compiling" OFF)
# A build from nothing takes half the time; after a change of one file more is compiled again. Only
# with compilers that were tried.
set(unity_default OFF)
if(CMAKE_CXX_COMPILER_ID MATCHES "^(GNU|Clang)$")
  set(unity_default ON)
endif()
option(FLUXGS_UNITY "Compile several files of a target as one" ${unity_default})

find_program(CCACHE_PROGRAM ccache)
if(CCACHE_PROGRAM)
  # Another clone of the same sources has nothing to compile again, in whatever language compilers speak,
  # with precompiled headers neither
  set(ccache_launcher ${CMAKE_COMMAND} -E env CCACHE_BASEDIR=${CMAKE_SOURCE_DIR} CCACHE_NOHASHDIR=1
                      CCACHE_SLOPPINESS=pch_defines,time_macros,locale)
  if(FLUXGS_COMPILER)  # a toolchain's name for a compiler that is a script
    list(APPEND ccache_launcher CCACHE_COMPILERCHECK=string:${FLUXGS_COMPILER})
  endif()
  list(APPEND ccache_launcher ${CCACHE_PROGRAM})
  set(CMAKE_C_COMPILER_LAUNCHER ${ccache_launcher})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${ccache_launcher})
endif()

# Target properties come through this interface library, so that fetched dependencies are not
# compiled with our warnings.
add_library(fluxgs_settings INTERFACE)
target_compile_options(fluxgs_settings INTERFACE
  -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor -Wold-style-cast -Wcast-qual
  $<$<BOOL:${FLUXGS_WARNINGS_AS_ERRORS}>:-Werror>
  -ffp-contract=off)  # The same results from every compiler: products are fused only where written

if(FLUXGS_UNITY AND CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
  # It also warns of names of other files
  target_compile_options(fluxgs_settings INTERFACE -Wno-shadow)
endif()

if(FLUXGS_SANITIZE)
  # A null pointer is found by the crash; the check of every access for it and for alignment takes a
  # third of the compiler's time. The preset fuzz checks alignment where files are read. GCC warns of
  # uninitialized values that only its instrumentation makes look so.
  target_compile_options(fluxgs_settings INTERFACE
    -fsanitize=address,undefined -fno-sanitize=null,alignment -fno-sanitize-recover=all
    -fno-omit-frame-pointer -Wno-maybe-uninitialized)
  target_link_options(fluxgs_settings INTERFACE -fsanitize=address,undefined)
endif()

if(FLUXGS_FUZZ)
  if(NOT CMAKE_CXX_COMPILER_ID STREQUAL "Clang")
    message(FATAL_ERROR "FLUXGS_FUZZ needs clang for libFuzzer; use the preset fuzz")
  endif()
  # clang warns about what libstdc++ 12 itself calls when it is compiled as C++23
  target_compile_options(fluxgs_settings INTERFACE
    -fsanitize=fuzzer-no-link,address,undefined,float-cast-overflow -fno-sanitize-recover=all
    -fno-omit-frame-pointer -Wno-deprecated-declarations)
  target_link_options(fluxgs_settings INTERFACE -fsanitize=address,undefined)
endif()

if(FLUXGS_TIDY)
  find_program(CLANG_TIDY NAMES clang-tidy-19 clang-tidy-18 clang-tidy REQUIRED)
  set(FLUXGS_CLANG_TIDY ${CLANG_TIDY} --quiet --extra-arg=-Wno-unknown-warning-option)
endif()

# fluxgs_in_app(NAME): a static library that is also linked into the app's shared one. Hidden
# symbols keep the code as fast as without.
function(fluxgs_in_app name)
  set_target_properties(${name} PROPERTIES POSITION_INDEPENDENT_CODE ON
                        CXX_VISIBILITY_PRESET hidden VISIBILITY_INLINES_HIDDEN ON)
endfunction()

# fluxgs_target(NAME): apply the project's settings to one of its own targets.
function(fluxgs_target name)
  target_link_libraries(${name} PRIVATE fluxgs_settings)
  set_target_properties(${name} PROPERTIES UNITY_BUILD ${FLUXGS_UNITY} UNITY_BUILD_BATCH_SIZE 12)
  if(FLUXGS_TIDY)
    set_target_properties(${name} PROPERTIES CXX_CLANG_TIDY "${FLUXGS_CLANG_TIDY}")
  endif()
endfunction()

# fluxgs_unhurried(NAME): a target whose own code takes little of the time of a run. It is optimised
# less, under the sanitizers not at all, and compiled in about half the time.
function(fluxgs_unhurried name)
  if(FLUXGS_SANITIZE)
    target_compile_options(${name} PRIVATE -O0)
  else()
    target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>)
  endif()
endfunction()

if(FLUXGS_BUNDLE)  # packages do not say where they were built
  add_compile_options(-ffile-prefix-map=${CMAKE_SOURCE_DIR}/=)
endif()
