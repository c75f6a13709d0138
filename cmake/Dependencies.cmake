# Every third-party library: the installed package where there is one (tools/setup installs them),
# otherwise the pinned source release. Those that a phone gets are the releases of Debian 12, with
# which the tests run (tools/android/sources); libwebp and libzip are newer, as Debian mends the old
# ones itself.
include(FetchContent)

# What is installed is of this machine: phones get what is fetched, and so do libraries that look for
# one another.
macro(fluxgs_package_choice)
  if(FLUXGS_PHONE)
    set(_choice OVERRIDE_FIND_PACKAGE)
  else()
    set(_choice FIND_PACKAGE_ARGS ${ARGN})
  endif()
endmacro()

# fluxgs_dependency(NAME GIT_URL TAG [find_package arguments...])
macro(fluxgs_dependency name url tag)
  fluxgs_package_choice(${ARGN})
  FetchContent_Declare(${name} GIT_REPOSITORY ${url} GIT_TAG ${tag} GIT_SHALLOW ON SYSTEM ${_choice})
  FetchContent_MakeAvailable(${name})
endmacro()

# Options that a project sets before its dependencies hold for those, even where they are old
set(CMAKE_POLICY_DEFAULT_CMP0077 NEW)
set(BUILD_SHARED_LIBS OFF)
set(BUILD_TESTING OFF)  # theirs
set(TINYGLTF_BUILD_LOADER_EXAMPLE OFF)
set(TINYGLTF_HEADER_ONLY OFF)
set(TINYGLTF_INSTALL OFF)
set(HWY_ENABLE_TESTS OFF)
set(HWY_ENABLE_EXAMPLES OFF)
set(HWY_ENABLE_CONTRIB OFF)
set(TBB_TEST OFF)
set(TBB_STRICT OFF)  # its own warnings are not errors of ours
set(SPDLOG_FMT_EXTERNAL ON)
set(NANOFLANN_BUILD_EXAMPLES OFF)
set(NANOFLANN_BUILD_TESTS OFF)
set(INSTALL_GTEST OFF)
foreach(unused BUILD_TOOLS BUILD_REGRESS BUILD_OSSFUZZ BUILD_EXAMPLES BUILD_DOC LIBZIP_DO_INSTALL
               ENABLE_COMMONCRYPTO ENABLE_GNUTLS ENABLE_MBEDTLS ENABLE_OPENSSL
               ENABLE_WINDOWS_CRYPTO ENABLE_BZIP2 ENABLE_LZMA ENABLE_ZSTD  # libzip
               WEBP_BUILD_ANIM_UTILS WEBP_BUILD_CWEBP WEBP_BUILD_DWEBP WEBP_BUILD_GIF2WEBP
               WEBP_BUILD_IMG2WEBP WEBP_BUILD_VWEBP WEBP_BUILD_WEBPINFO WEBP_BUILD_WEBPMUX
               WEBP_BUILD_EXTRAS)
  set(${unused} OFF)
endforeach()

if(FLUXGS_PHONE)
  # As their authors build them: newer C++ libraries include less by the way
  set(CMAKE_CXX_STANDARD 17)
  set(ZSTD_BUILD_SHARED OFF)
  set(ZSTD_BUILD_PROGRAMS OFF)
  set(ZSTD_LEGACY_SUPPORT OFF)
  set(EIGEN_BUILD_DOC OFF)
endif()

set(_github https://github.com)
fluxgs_dependency(glm ${_github}/g-truc/glm 0.9.9.8)
fluxgs_dependency(fmt ${_github}/fmtlib/fmt 9.1.0)
fluxgs_dependency(nlohmann_json ${_github}/nlohmann/json v3.11.2)
fluxgs_dependency(TinyGLTF ${_github}/syoyo/tinygltf v2.7.0)
fluxgs_dependency(Eigen3 https://gitlab.com/libeigen/eigen 3.4.0)
# zstd keeps its CMake project in a sub-folder
fluxgs_package_choice()
FetchContent_Declare(zstd GIT_REPOSITORY ${_github}/facebook/zstd GIT_TAG v1.5.4 GIT_SHALLOW ON SYSTEM
                     SOURCE_SUBDIR build/cmake ${_choice})
FetchContent_MakeAvailable(zstd)
set(CMAKE_UNITY_BUILD ${FLUXGS_UNITY})  # its hundred small files take three minutes one by one
fluxgs_dependency(draco ${_github}/google/draco 1.5.5)
set(CMAKE_UNITY_BUILD OFF)
if(FLUXGS_PHONE)
  # Without images of other kinds than RGBA and without scaling, which nothing here asks for
  string(APPEND CMAKE_C_FLAGS " -DWEBP_REDUCE_CSP -DWEBP_REDUCE_SIZE")
endif()
fluxgs_dependency(WebP ${_github}/webmproject/libwebp v1.5.0)
fluxgs_dependency(libzip ${_github}/nih-at/libzip v1.10.1)
# Every system has it, phones too; fetched, its target would clash with the copy inside a fetched
# OpenCV
find_package(ZLIB REQUIRED)

# One name each, whether the library was installed or fetched.
function(fluxgs_alias name)
  foreach(fetched IN LISTS ARGN)
    if(TARGET ${fetched} AND NOT TARGET ${name})
      add_library(${name} ALIAS ${fetched})
    endif()
  endforeach()
endfunction()
fluxgs_alias(TinyGLTF::TinyGLTF tinygltf)
fluxgs_alias(zstd::libzstd_shared libzstd_shared libzstd_static)
fluxgs_alias(WebP::webp webp)
fluxgs_alias(libzip::zip zip)

# fluxgs_headers(NAME FOLDER...): of a fetched library that does not say itself where they are.
function(fluxgs_headers name)
  get_target_property(target ${name} ALIASED_TARGET)
  target_include_directories(${target} SYSTEM INTERFACE "$<BUILD_INTERFACE:${ARGN}>")
endfunction()
if(draco_SOURCE_DIR)
  fluxgs_headers(draco::draco ${draco_SOURCE_DIR}/src ${CMAKE_BINARY_DIR})
endif()
if(zstd_SOURCE_DIR)
  fluxgs_headers(zstd::libzstd_shared ${zstd_SOURCE_DIR}/lib)
endif()
if(FLUXGS_PHONE)
  # They read heads and messages of a few kB, and would take a tenth of the library
  foreach(small IN ITEMS tinygltf fmt zip)
    target_compile_options(${small} PRIVATE -Os)
  endforeach()
  set(CMAKE_CXX_STANDARD 23)
  return()
endif()

fluxgs_dependency(spdlog ${_github}/gabime/spdlog v1.14.1)
fluxgs_dependency(CLI11 ${_github}/CLIUtils/CLI11 v2.4.2)
fluxgs_dependency(hwy ${_github}/google/highway 1.2.0)
fluxgs_alias(hwy::hwy hwy)
# Not by the name TBB: its project takes the variable TBB_DIR for "use the one over there"
fluxgs_dependency(oneTBB ${_github}/oneapi-src/oneTBB v2021.13.0 NAMES TBB)
fluxgs_dependency(nanoflann ${_github}/jlblancoc/nanoflann v1.5.5)
fluxgs_dependency(utf8proc ${_github}/JuliaStrings/utf8proc v2.10.0)
fluxgs_alias(utf8proc::utf8proc utf8proc)
find_package(JPEG REQUIRED)
find_package(PNG REQUIRED)
set(_opencv_modules core imgproc imgcodecs features2d calib3d)
list(JOIN _opencv_modules "," BUILD_LIST)
foreach(unused BUILD_TESTS BUILD_PERF_TESTS BUILD_EXAMPLES BUILD_opencv_apps BUILD_JAVA
               BUILD_opencv_python3 WITH_GTK WITH_QT WITH_FFMPEG WITH_GSTREAMER WITH_IPP WITH_ITT
               WITH_ADE WITH_OPENEXR WITH_PROTOBUF WITH_OPENJPEG WITH_JASPER WITH_QUIRC
               WITH_OPENCL WITH_1394 WITH_LAPACK)
  set(${unused} OFF)
endforeach()
set(OPENCV_EXTRA_CXX_FLAGS -w)  # its enumerations warn in C++20, hundreds of times
fluxgs_dependency(OpenCV ${_github}/opencv/opencv 4.10.0 COMPONENTS ${_opencv_modules})

unset(BUILD_TESTING)
include(CTest)
if(BUILD_TESTING)
  fluxgs_dependency(GTest ${_github}/google/googletest v1.14.0 NAMES GTest)
endif()

# OpenCV's own targets do not know their headers while they are being built.
add_library(fluxgs_opencv INTERFACE)
foreach(module IN LISTS _opencv_modules)
  target_link_libraries(fluxgs_opencv INTERFACE opencv_${module})
endforeach()
if(opencv_SOURCE_DIR)
  target_include_directories(fluxgs_opencv SYSTEM INTERFACE ${OPENCV_CONFIG_FILE_INCLUDE_DIR}
                             ${opencv_SOURCE_DIR}/include)
  foreach(module IN LISTS _opencv_modules ITEMS flann)
    target_include_directories(fluxgs_opencv SYSTEM INTERFACE
                               ${opencv_SOURCE_DIR}/modules/${module}/include)
  endforeach()
endif()
