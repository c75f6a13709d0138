# Run as a script: writes a shader with its defines as gl/program.cpp hands it to the driver.
#   cmake -DSHADER=… -DOUTPUT=… "-DDEFINES=NAME VALUE;…" -P variant.cmake
file(READ ${SHADER} _text)
string(FIND "${_text}" "\n" _end)
math(EXPR _end "${_end} + 1")
string(SUBSTRING "${_text}" 0 ${_end} _version)
string(SUBSTRING "${_text}" ${_end} -1 _rest)
set(_defines "")
foreach(_define IN LISTS DEFINES)
  string(APPEND _defines "#define ${_define}\n")
endforeach()
file(WRITE ${OUTPUT} "${_version}${_defines}#line 2\n${_rest}")
