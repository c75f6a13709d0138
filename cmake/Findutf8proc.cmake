# Debian's libutf8proc-dev has no CMake configuration file.
include(${CMAKE_CURRENT_LIST_DIR}/PlainLibrary.cmake)
find_plain_library(utf8proc utf8proc.h utf8proc)
