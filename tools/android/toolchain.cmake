# The check compiler of tools/android/toolchain: 64-bit ARM Android, without the NDK.
set(CMAKE_SYSTEM_NAME Linux)  # "Android" wants an NDK
set(CMAKE_SYSTEM_PROCESSOR aarch64)
get_filename_component(_packages ${CMAKE_CURRENT_LIST_DIR}/../../build/packages/android ABSOLUTE)
set(_toolchain ${_packages}/toolchain)
set(CMAKE_C_COMPILER ${_toolchain}/bin/cc)
set(CMAKE_CXX_COMPILER ${_toolchain}/bin/c++)
# For ccache: the compiler is a script that names its own folder, made anew in each clone
file(READ ${_toolchain}/STAMP FLUXGS_COMPILER LIMIT 64)
string(REGEX MATCH "^[0-9.]+-[0-9a-f]+" FLUXGS_COMPILER "${FLUXGS_COMPILER}")
set(CMAKE_AR ${_toolchain}/bin/ar CACHE FILEPATH "")
set(CMAKE_RANLIB ${_toolchain}/bin/ranlib CACHE FILEPATH "")
# There is no crt1.o to make programs with, but what CMake tries out must find all its functions
set(CMAKE_EXE_LINKER_FLAGS_INIT "-shared -Wl,-z,defs")
set(CMAKE_FIND_ROOT_PATH ${_toolchain})
set(CMAKE_FIND_ROOT_PATH_MODE_PACKAGE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_C_FLAGS_INIT "-fno-sanitize=all -ffunction-sections -fdata-sections")  # zig turns some on by itself
set(CMAKE_CXX_FLAGS_INIT "-fno-sanitize=all -ffunction-sections -fdata-sections")
set(CMAKE_SHARED_LINKER_FLAGS_INIT "-Wl,-z,max-page-size=16384 -Wl,--build-id=sha1")
# The phone's own library, of which only the names are here
set(ZLIB_INCLUDE_DIR ${_toolchain}/others CACHE PATH "")
set(ZLIB_LIBRARY ${_toolchain}/lib/libz.so CACHE FILEPATH "")

include(${CMAKE_CURRENT_LIST_DIR}/sources.cmake)
