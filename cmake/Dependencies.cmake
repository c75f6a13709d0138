# Every third-party library: the installed package where there is one (tools/setup installs them),
# otherwise the pinned source release.
include(FetchContent)

# fluxgs_dependency(NAME GIT_URL TAG [find_package arguments...])
macro(fluxgs_dependency name url tag)
  FetchContent_Declare(${name} GIT_REPOSITORY ${url} GIT_TAG ${tag} GIT_SHALLOW ON SYSTEM
                       FIND_PACKAGE_ARGS ${ARGN})
  FetchContent_MakeAvailable(${name})
endmacro()

set(BUILD_SHARED_LIBS OFF)
set(TINYGLTF_BUILD_LOADER_EXAMPLE OFF)
set(TINYGLTF_HEADER_ONLY OFF)
set(TINYGLTF_INSTALL OFF)
set(HWY_ENABLE_TESTS OFF)
set(HWY_ENABLE_EXAMPLES OFF)
set(HWY_ENABLE_CONTRIB OFF)
set(TBB_TEST OFF)
set(SPDLOG_FMT_EXTERNAL ON)
set(NANOFLANN_BUILD_EXAMPLES OFF)
set(NANOFLANN_BUILD_TESTS OFF)
set(INSTALL_GTEST OFF)

set(_github https://github.com)
fluxgs_dependency(glm ${_github}/g-truc/glm 1.0.1)
fluxgs_dependency(fmt ${_github}/fmtlib/fmt 10.2.1)
fluxgs_dependency(spdlog ${_github}/gabime/spdlog v1.14.1)
fluxgs_dependency(nlohmann_json ${_github}/nlohmann/json v3.11.3)
fluxgs_dependency(TinyGLTF ${_github}/syoyo/tinygltf v2.9.3)
fluxgs_dependency(Eigen3 https://gitlab.com/libeigen/eigen 3.4.0)
fluxgs_dependency(CLI11 ${_github}/CLIUtils/CLI11 v2.4.2)
fluxgs_dependency(hwy ${_github}/google/highway 1.2.0)
fluxgs_dependency(TBB ${_github}/oneapi-src/oneTBB v2021.13.0)
fluxgs_dependency(nanoflann ${_github}/jlblancoc/nanoflann v1.5.5)
# zstd keeps its CMake project in a sub-folder
FetchContent_Declare(zstd GIT_REPOSITORY ${_github}/facebook/zstd GIT_TAG v1.5.6 GIT_SHALLOW ON SYSTEM
                     SOURCE_SUBDIR build/cmake FIND_PACKAGE_ARGS)
FetchContent_MakeAvailable(zstd)
fluxgs_dependency(draco ${_github}/google/draco 1.5.7)
find_package(JPEG REQUIRED)
find_package(OpenCV REQUIRED COMPONENTS core imgproc imgcodecs features2d calib3d)

include(CTest)
if(BUILD_TESTING)
  fluxgs_dependency(GTest ${_github}/google/googletest v1.14.0 NAMES GTest)
endif()

# One name each, whether the library was installed or fetched.
if(NOT TARGET TinyGLTF::TinyGLTF)
  add_library(TinyGLTF::TinyGLTF ALIAS tinygltf)
endif()
if(NOT TARGET zstd::libzstd_shared)
  add_library(zstd::libzstd_shared ALIAS libzstd_shared)
endif()
