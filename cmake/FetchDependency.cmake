# How a third-party library comes: the installed package where there is one, otherwise a release of its
# authors by URL and SHA-256. Archives are kept in FLUXGS_DOWNLOADS, one folder for all builds of this
# tree: a second build fetches nothing, and neither does a machine without a network to which the folder
# was copied. No git is needed.
include(FetchContent)

# CMake 4 refuses the oldest CMake that some of them name, such as glm
set(CMAKE_POLICY_VERSION_MINIMUM 3.5)
set(FLUXGS_DOWNLOADS ${CMAKE_SOURCE_DIR}/build/downloads CACHE PATH
    "Archives of third-party libraries, which all builds share")
if(ANDROID AND CMAKE_BINARY_DIR MATCHES "/\\.cxx/")
  # Gradle's own folder is made anew with each change of the settings, and its path is too long for
  # Eigen on Windows
  set(FETCHCONTENT_BASE_DIR ${CMAKE_SOURCE_DIR}/build/gradle/${ANDROID_ABI}-${CMAKE_BUILD_TYPE}
      CACHE PATH "" FORCE)
endif()

# fluxgs_package_choice([find_package arguments...]): what is installed is of this machine; phones get
# what is fetched, and so do libraries that look for one another.
macro(fluxgs_package_choice)
  if(FLUXGS_PHONE)
    set(_choice OVERRIDE_FIND_PACKAGE)
  else()
    set(_choice FIND_PACKAGE_ARGS ${ARGN})
  endif()
endmacro()

# fluxgs_dependency(NAME URL SHA256 [SUBDIR folder-of-its-CMakeLists.txt] [find_package arguments...])
macro(fluxgs_dependency name url sha256)
  cmake_parse_arguments(_dependency "" SUBDIR "" ${ARGN})
  fluxgs_package_choice(${_dependency_UNPARSED_ARGUMENTS})
  string(REGEX MATCH "\\.(zip|tar\\.[a-z0-9]+)$" _ending ${url})
  string(SUBSTRING ${sha256} 0 8 _hash)
  FetchContent_Declare(
    ${name}
    URL ${url}
    URL_HASH SHA256=${sha256}
    DOWNLOAD_DIR ${FLUXGS_DOWNLOADS}
    DOWNLOAD_NAME ${name}-${_hash}${_ending}
    DOWNLOAD_EXTRACT_TIMESTAMP OFF
    SOURCE_SUBDIR "${_dependency_SUBDIR}"
    SYSTEM
    ${_choice})
  FetchContent_MakeAvailable(${name})
endmacro()
