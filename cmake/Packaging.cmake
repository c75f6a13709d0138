# Installing the program, and a package of it for systems without its libraries (tools/package).
option(FLUXGS_BUNDLE "Install the libraries that the program needs beside it" OFF)

# What only this program uses. The path is relative, so that the folder can be moved; as DT_RPATH it
# also holds for the libraries that these need themselves.
set(fluxgs_private lib/fluxgs)
set_target_properties(fluxgs PROPERTIES INSTALL_RPATH "$ORIGIN/../${fluxgs_private}")
target_link_options(fluxgs PRIVATE -Wl,--disable-new-dtags)

install(TARGETS fluxgs RUNTIME_DEPENDENCY_SET fluxgs_libraries RUNTIME DESTINATION bin)
install(FILES README.md LICENSE CHANGELOG.md DESTINATION share/doc/fluxgs)
install(DIRECTORY docs/ DESTINATION share/doc/fluxgs/docs)
# Loaded while the program runs; without them it says what is missing
set(packages ${CMAKE_SOURCE_DIR}/build/packages)
install(FILES ${packages}/onnxruntime/libonnxruntime.so.1 DESTINATION ${fluxgs_private} OPTIONAL)
install(DIRECTORY ${packages}/angle DESTINATION ${fluxgs_private} OPTIONAL)

if(NOT FLUXGS_BUNDLE)
  return()
endif()

# All but those of every system that the program can run on: the C and C++ libraries
install(RUNTIME_DEPENDENCY_SET fluxgs_libraries
        PRE_EXCLUDE_REGEXES "^lib(c|m|dl|rt|pthread|gcc_s|stdc\\+\\+)\\.so" "^ld-linux"
        DESTINATION ${fluxgs_private})
find_library(FLUXGS_GLFW_LIBRARY NAMES libglfw.so.3 REQUIRED)
file(REAL_PATH ${FLUXGS_GLFW_LIBRARY} glfw)
install(FILES ${glfw} RENAME libglfw.so.3 DESTINATION ${fluxgs_private})

# tools/package installs here, adds the licences of the libraries, and knows what the files depend on
set(CPACK_INSTALL_CMAKE_PROJECTS "")
set(CPACK_INSTALLED_DIRECTORIES "${CMAKE_BINARY_DIR}/stage;/")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_PACKAGE_NAME fluxgs)
set(CPACK_PACKAGE_CONTACT "The authors of Flux-GS <fluxgs@localhost>")
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
set(CPACK_DEBIAN_COMPRESSION_TYPE xz)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "libegl1, libgl1-mesa-dri, libx11-6, colmap, ffmpeg")
include(CPack)
