# Run as a script: resolves `#include "…"` in a shader (drivers know no includes), writes the
# result, and writes a C++ source that holds it as a string.
#   cmake -DSHADER=… -DOUTPUT=… -DCPP=… -DNAME=… -P embed.cmake
# So that a driver can say where an error is, every inclusion gets a thousand line numbers of its own
# (#line; GLSL ES 3.10, section 3.5), and a comment says whose they are (gl/shader_log.h reads it).
# The number of a source string, #line's second argument, would be for that, but Mesa forgets it:
# YYLLOC_DEFAULT of its glsl_parser.yy sets 0.
get_filename_component(_folder ${SHADER} DIRECTORY)
set(_inclusions 0)

# Appends to _text the lines of a file, the first of which has the number `line`.
function(flatten file line)
  file(READ ${file} rest)
  string(REGEX REPLACE "[^\n]" "" breaks "${rest}")
  string(LENGTH "${breaks}" lines)
  if(lines GREATER 998)
    message(FATAL_ERROR "${file}: has ${lines} lines; 998 at most were expected")
  endif()
  while(rest MATCHES "#include \"([^\"]+)\"\n")
    set(included ${CMAKE_MATCH_1})
    string(FIND "${rest}" "${CMAKE_MATCH_0}" start)
    string(LENGTH "${CMAKE_MATCH_0}" length)
    string(SUBSTRING "${rest}" 0 ${start} before)
    math(EXPR end "${start} + ${length}")
    string(SUBSTRING "${rest}" ${end} -1 rest)
    string(REGEX REPLACE "[^\n]" "" breaks "${before}")
    string(LENGTH "${breaks}" passed)
    math(EXPR line "${line} + ${passed} + 1")

    math(EXPR _inclusions "${_inclusions} + 1")
    math(EXPR first "1000 * ${_inclusions} + 1")
    string(APPEND _text
           "${before}// line ${first} is line 1 of ${included}\n#line ${first}\n")
    flatten(${_folder}/${included} ${first})
    string(APPEND _text "#line ${line}\n")
  endwhile()
  set(_text "${_text}${rest}" PARENT_SCOPE)
  set(_inclusions ${_inclusions} PARENT_SCOPE)
endfunction()

flatten(${SHADER} 1)
file(WRITE ${OUTPUT} "${_text}")
file(WRITE ${CPP} "#include \"shaders/shaders.h\"\n"
  "namespace fluxgs::shaders {\nconst std::string_view ${NAME} = R\"glsl(${_text})glsl\";\n}\n")
