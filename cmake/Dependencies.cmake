# Every third-party library: the installed package where there is one (tools/setup installs them),
# otherwise the pinned source release. Those that a phone gets are the releases of Debian 12, with
# which the tests run (tools/android/sources); libwebp and libzip are newer, as Debian mends the old
# ones itself.
# Behind each hash stands who publishes it for the same archive.
include(FetchDependency)
if(FLUXGS_PHONE AND NOT FETCHCONTENT_SOURCE_DIR_GLM)
  file(LOCK ${FLUXGS_DOWNLOADS} DIRECTORY GUARD FILE)  # Gradle configures several builds at a time
endif()

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
fluxgs_dependency(glm ${_github}/g-truc/glm/archive/refs/tags/0.9.9.8.tar.gz
                  7d508ab72cb5d43227a3711420f06ff99b0a0cb63ee2f93631b162bfe1fe9592)  # xmake, Termux
fluxgs_dependency(fmt ${_github}/fmtlib/fmt/archive/refs/tags/9.1.0.tar.gz
                  5dea48d1fcddc3ec571ce2058e13910a0d4a6bab4cc09a809d8b1dd1c88ae6f2)  # Bazel builds
fluxgs_dependency(nlohmann_json ${_github}/nlohmann/json/releases/download/v3.11.2/json.tar.xz
                  8c4b26bf4b422252e13f332bc5e388ec0ab5c3443d24399acb675e68278d341f)  # KDE Craft
fluxgs_dependency(TinyGLTF ${_github}/syoyo/tinygltf/archive/refs/tags/v2.7.0.tar.gz
                  a1bbc0b831719e3a809a1bb01ce299a60e80b4e15221f58e822303ba22a69d45)  # Spack
fluxgs_dependency(Eigen3 https://gitlab.com/libeigen/eigen/-/archive/3.4.0/eigen-3.4.0.tar.bz2
                  b4c198460eba6f28d34894e3a5710998818515104d6e74e5cc331ce31e46e626)  # Conan Center
fluxgs_dependency(zstd ${_github}/facebook/zstd/releases/download/v1.5.4/zstd-1.5.4.tar.gz
                  0f470992aedad543126d06efab344dc5f3e171893810455787d38347343a4424 SUBDIR build/cmake)  # Yggdrasil
set(CMAKE_UNITY_BUILD ${FLUXGS_UNITY})  # its hundred small files take three minutes one by one
fluxgs_dependency(draco ${_github}/google/draco/archive/1.5.5.tar.gz
                  6b7994150bbc513abcdbe22ad778d6b2df10fc8cdc7035e916985b2a209ab826)  # Homebrew
set(CMAKE_UNITY_BUILD OFF)
if(FLUXGS_PHONE)
  # Draco has no options for all of its features. Compact files hold points, in the format of today.
  set(_features "#pragma once\n#define DRACO_POINT_CLOUD_COMPRESSION_SUPPORTED\n")
  file(WRITE ${CMAKE_BINARY_DIR}/draco/draco_features.h "${_features}")
  # Without images of other kinds than RGBA and without scaling, which nothing here asks for
  string(APPEND CMAKE_C_FLAGS " -DWEBP_REDUCE_CSP -DWEBP_REDUCE_SIZE")
endif()
fluxgs_dependency(WebP https://storage.googleapis.com/downloads.webmproject.org/releases/webp/libwebp-1.5.0.tar.gz
                  7d6fab70cf844bf6769077bd5d7a74893f8ffd4dfb42861745750c63c2a5c92c)  # Debian, Homebrew
if(FLUXGS_WEB)
  fluxgs_dependency(ZLIB https://zlib.net/fossils/zlib-1.2.13.tar.gz
                    b3a24de97a8fdbc835b9833169501030b8977031bcb54b3b3ac13740f846ab30)
else()
  # Every system has it, phones too; fetched, its target would clash with the copy inside a fetched
  # OpenCV
  find_package(ZLIB REQUIRED)
endif()
fluxgs_dependency(libzip ${_github}/nih-at/libzip/releases/download/v1.10.1/libzip-1.10.1.tar.gz
                  9669ae5dfe3ac5b3897536dc8466a874c8cf2c0e3b1fdd08d75b273884299363)  # Conan Center

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
  set(_small tinygltf fmt zip)
  set(_optimise -Os)
  if(FLUXGS_WEB)  # every byte is downloaded
    list(APPEND _small webpdecode webpdspdecode webputilsdecode webpdsp webputils webpencode)
    set(_optimise -Oz)
  endif()
  foreach(small IN LISTS _small)
    target_compile_options(${small} PRIVATE ${_optimise})
  endforeach()
  set(CMAKE_CXX_STANDARD 23)
  return()
endif()

fluxgs_dependency(spdlog ${_github}/gabime/spdlog/archive/refs/tags/v1.14.1.tar.gz
                  1586508029a7d0670dfcb2d97575dcdc242d3868a259742b69f100801ab4e16b)  # CMake builds
fluxgs_dependency(CLI11 ${_github}/CLIUtils/CLI11/archive/v2.4.2.tar.gz
                  f2d893a65c3b1324c50d4e682c0cdc021dd0477ae2c048544f39eed6654b699a)  # Conan Center
fluxgs_dependency(hwy ${_github}/google/highway/archive/refs/tags/1.2.0.tar.gz
                  7e0be78b8318e8bdbf6fa545d2ecb4c90f947df03f7aadc42c1967f019e63343)  # Homebrew
fluxgs_alias(hwy::hwy hwy)
# Not by the name TBB: its project takes the variable TBB_DIR for "use the one over there"
fluxgs_dependency(oneTBB ${_github}/oneapi-src/oneTBB/archive/refs/tags/v2021.13.0.tar.gz
                  3ad5dd08954b39d113dc5b3f8a8dc6dc1fd5250032b7c491eb07aed5c94133e1 NAMES TBB)  # Homebrew, Termux
fluxgs_dependency(nanoflann ${_github}/jlblancoc/nanoflann/archive/refs/tags/v1.5.5.zip
                  57496cb27e1310a77a367e5a902c8f1c700496d91ac54ccc87fbe9ccc28bc6cc)  # one other project only
fluxgs_dependency(utf8proc ${_github}/JuliaStrings/utf8proc/archive/refs/tags/v2.10.0.tar.gz
                  6f4f1b639daa6dca9f80bc5db1233e9cbaa31a67790887106160b33ef743f136)  # Homebrew
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
fluxgs_dependency(OpenCV ${_github}/opencv/opencv/archive/refs/tags/4.10.0.tar.gz
                  b2171af5be6b26f7a06b1229948bbb2bdaa74fcf5cd097e0af6378fce50a6eb9 COMPONENTS ${_opencv_modules})  # xmake, Termux

unset(BUILD_TESTING)
include(CTest)
if(BUILD_TESTING)
  fluxgs_dependency(GTest ${_github}/google/googletest/archive/refs/tags/v1.14.0.tar.gz
                    8ad598c73ad796e0d8280b082cebd82a630d73e73cd3c70057938a6501bba5d7 NAMES GTest)  # Bazel builds
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
