# cmake/FetchDependency.cmake takes a library from the folder of archives, without a network, and
# refuses an archive with another hash.
#   cmake -DROOT=FOLDER -DSCRATCH=FOLDER -P tests/fetch_dependency.cmake
file(REMOVE_RECURSE "${SCRATCH}")
# Old, as some libraries are: CMake 4 takes no minimum below 3.5 by itself
file(WRITE "${SCRATCH}/old-1.0/build/CMakeLists.txt"
     "cmake_minimum_required(VERSION 3.1)\nproject(old LANGUAGES NONE)\nadd_library(old INTERFACE)\n")
file(MAKE_DIRECTORY "${SCRATCH}/downloads")
execute_process(COMMAND ${CMAKE_COMMAND} -E tar czf old.tar.gz old-1.0 WORKING_DIRECTORY "${SCRATCH}"
                COMMAND_ERROR_IS_FATAL ANY)
file(SHA256 "${SCRATCH}/old.tar.gz" sha256)
string(SUBSTRING ${sha256} 0 8 hash)
set(archive "${SCRATCH}/downloads/old-${hash}.tar.gz")
file(WRITE "${SCRATCH}/project/CMakeLists.txt" "
cmake_minimum_required(VERSION 3.25)
project(taker LANGUAGES NONE)
list(APPEND CMAKE_MODULE_PATH ${ROOT}/cmake)
include(FetchDependency)
fluxgs_dependency(old nowhere://invalid/old.tar.gz ${sha256} SUBDIR build)
if(NOT TARGET old)
  message(FATAL_ERROR \"no target\")
endif()
")

# configure(BUILD): sets `status` and `said`.
macro(configure build)
  execute_process(
    COMMAND ${CMAKE_COMMAND} -S "${SCRATCH}/project" -B "${SCRATCH}/${build}" -DFLUXGS_PHONE=ON
            -DFLUXGS_DOWNLOADS=${SCRATCH}/downloads
    RESULT_VARIABLE status OUTPUT_VARIABLE said ERROR_VARIABLE said)
endmacro()

file(COPY_FILE "${SCRATCH}/old.tar.gz" "${archive}")
foreach(build first second)
  configure(${build})
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "the archive is not taken: ${said}")
  endif()
endforeach()
file(WRITE "${archive}" "something else")
configure(third)
if(status EQUAL 0 OR NOT said MATCHES "nowhere:")
  message(FATAL_ERROR "an archive with another hash is taken: ${said}")
endif()
