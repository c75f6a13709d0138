# Emscripten (tools/deps/emscripten): WebAssembly for browsers, compiled by clang 19 itself, as em++ needs most
# of a second for each file, and linked by em++.
set(CMAKE_SYSTEM_NAME Linux)  # CMake and the libraries know no Emscripten, whose C library is much like Linux's
set(CMAKE_SYSTEM_PROCESSOR wasm32)
get_filename_component(_emscripten ${CMAKE_CURRENT_LIST_DIR}/../../build/packages/emscripten ABSOLUTE)
if(NOT EXISTS ${_emscripten}/cflags-fwasm-exceptions)
  message(FATAL_ERROR "Emscripten is missing: run tools/setup --web")
endif()
set(CMAKE_C_COMPILER /usr/lib/llvm-19/bin/clang)
set(CMAKE_CXX_COMPILER /usr/lib/llvm-19/bin/clang++)
set(CMAKE_AR /usr/lib/llvm-19/bin/llvm-ar CACHE FILEPATH "")
set(CMAKE_RANLIB /usr/lib/llvm-19/bin/llvm-ranlib CACHE FILEPATH "")
file(READ ${_emscripten}/cflags-fwasm-exceptions _flags)
string(STRIP "${_flags}" _flags)
set(_flags "${_flags} -msimd128 -ffunction-sections -fdata-sections")
set(CMAKE_C_FLAGS_INIT "${_flags}")
set(CMAKE_CXX_FLAGS_INIT "${_flags}")
# Optimised as a whole it is a quarter smaller
set(CMAKE_C_FLAGS_RELEASE "-O2 -DNDEBUG -flto" CACHE STRING "")
set(CMAKE_CXX_FLAGS_RELEASE "-Oz -DNDEBUG -fno-rtti -flto" CACHE STRING "")
foreach(_language C CXX)
  set(CMAKE_${_language}_LINK_EXECUTABLE
      "${_emscripten}/em++ -O1 -fwasm-exceptions <LINK_FLAGS> <OBJECTS> -o <TARGET> <LINK_LIBRARIES>")
endforeach()
# What CMake would find out by linking programs
foreach(_language C CXX)
  set(CMAKE_${_language}_COMPILER_WORKS TRUE)
  set(CMAKE_${_language}_ABI_COMPILED TRUE)
  set(CMAKE_${_language}_SIZEOF_DATA_PTR 4)
  set(CMAKE_${_language}_BYTE_ORDER LITTLE_ENDIAN)
endforeach()
set(CMAKE_SIZEOF_VOID_P 4)
set(CMAKE_BUILD_WITH_INSTALL_RPATH ON)  # there are no shared libraries
set(CMAKE_FIND_ROOT_PATH ${_emscripten}/root/usr/share/emscripten/cache/sysroot)
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)

# Linking programs to try things out would take minutes: what those would find is written down
include(${CMAKE_CURRENT_LIST_DIR}/probes.cmake)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)
include(${CMAKE_CURRENT_LIST_DIR}/../android/sources.cmake)
set(FETCHCONTENT_SOURCE_DIR_ZLIB ${CMAKE_CURRENT_LIST_DIR}/zlib CACHE PATH "")
