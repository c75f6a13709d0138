# Run as a script: resolves `#include "…"` in a shader (drivers know no includes), writes the
# result, and writes a C++ source that holds it as a string.
#   cmake -DSHADER=… -DOUTPUT=… -DCPP=… -DNAME=… -P embed.cmake
get_filename_component(_folder ${SHADER} DIRECTORY)
file(READ ${SHADER} _text)
while(_text MATCHES "#include \"([^\"]+)\"\n")
  file(READ ${_folder}/${CMAKE_MATCH_1} _part)
  string(REPLACE "${CMAKE_MATCH_0}" "${_part}" _text "${_text}")
endwhile()
file(WRITE ${OUTPUT} "${_text}")
file(WRITE ${CPP} "#include \"shaders/shaders.h\"\n"
  "namespace fluxgs::shaders {\nconst std::string_view ${NAME} = R\"glsl(${_text})glsl\";\n}\n")
