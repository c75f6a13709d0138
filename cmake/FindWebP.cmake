# Debian's libwebp-dev has no CMake configuration file.
include(${CMAKE_CURRENT_LIST_DIR}/PlainLibrary.cmake)
find_plain_library(WebP webp/decode.h webp)
