# libzip's own configuration file fails where its command line tools (zipcmp and others, packages of
# their own) are not installed; the library is all that is needed.
include(${CMAKE_CURRENT_LIST_DIR}/PlainLibrary.cmake)
find_plain_library(libzip zip.h zip)
