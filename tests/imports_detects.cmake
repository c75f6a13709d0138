# The check of includes finds an upward one: plants it in a copy of a small tree.
#   cmake -DROOT=FOLDER -DSCRATCH=FOLDER -P tests/imports_detects.cmake
file(REMOVE_RECURSE "${SCRATCH}")
file(COPY "${ROOT}/docs/architecture.md" DESTINATION "${SCRATCH}/docs")
file(WRITE "${SCRATCH}/trainer/train/trainer.h" "#pragma once\n")
file(WRITE "${SCRATCH}/trainer/core/fine.h" "#pragma once\n")
file(WRITE "${SCRATCH}/trainer/train/fine.cpp" "#include \"trainer/core/fine.h\"\n")

function(expect_status wanted)
  execute_process(COMMAND ${CMAKE_COMMAND} "-DROOT=${SCRATCH}" -P "${ROOT}/tests/imports.cmake"
                  RESULT_VARIABLE status ERROR_VARIABLE said OUTPUT_QUIET)
  string(REGEX REPLACE "[ \n]+" " " said "${said}")
  set(said "${said}" PARENT_SCOPE)
  if(wanted STREQUAL "pass" AND NOT status EQUAL 0)
    message(FATAL_ERROR "a tree without upward includes is refused: ${said}")
  elseif(wanted STREQUAL "fail" AND status EQUAL 0)
    message(FATAL_ERROR "an upward include is not found")
  endif()
endfunction()

expect_status(pass)
file(WRITE "${SCRATCH}/trainer/core/upward.cpp" "#include \"trainer/train/trainer.h\"\n")
expect_status(fail)
if(NOT said MATCHES "trainer/core/upward.cpp: includes trainer/train/trainer.h, but trainer/core may include only")
  message(FATAL_ERROR "the error does not name the place: ${said}")
endif()
file(REMOVE "${SCRATCH}/trainer/core/upward.cpp")
file(WRITE "${SCRATCH}/trainer/unlisted/new.cpp" "#include \"trainer/core/fine.h\"\n")
expect_status(fail)
