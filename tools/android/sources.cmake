# CMake's FetchContent takes the libraries from where tools/android/sources has put them.
get_filename_component(_sources ${CMAKE_CURRENT_LIST_DIR}/../../build/packages/android/sources
                       ABSOLUTE)
foreach(_pair GLM=glm FMT=fmtlib NLOHMANN_JSON=nlohmann-json3 EIGEN3=eigen3
        ZSTD=libzstd DRACO=draco WEBP=libwebp LIBZIP=libzip)
  string(REGEX MATCH "(.*)=(.*)" _pair ${_pair})
  set(FETCHCONTENT_SOURCE_DIR_${CMAKE_MATCH_1} ${_sources}/${CMAKE_MATCH_2} CACHE PATH "")
endforeach()
set(FETCHCONTENT_SOURCE_DIR_TINYGLTF ${CMAKE_CURRENT_LIST_DIR}/tinygltf CACHE PATH "")
