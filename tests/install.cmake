# cmake -DBUILD=... -DSOURCE=... -DSCRATCH=... -DPYTHON=... -P install.cmake
# The program runs from where it was installed to, and from where pip puts a wheel of it.
function(run)
  execute_process(COMMAND ${ARGN} OUTPUT_VARIABLE output ERROR_VARIABLE output RESULT_VARIABLE status)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "${ARGN}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${SCRATCH})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${SCRATCH}/first)
# A folder that was moved is as good
file(RENAME ${SCRATCH}/first ${SCRATCH}/moved)
run(${SCRATCH}/moved/bin/fluxgs --version)
string(STRIP "${output}" version)
foreach(file LICENSE README.md docs/guide/train.md)
  if(NOT EXISTS ${SCRATCH}/moved/share/doc/fluxgs/${file})
    message(FATAL_ERROR "not installed: ${file}")
  endif()
endforeach()

# The tags of a wheel are those of the machine: any glibc is old enough here
if(PYTHON)
  run(${PYTHON} ${SOURCE}/tools/packaging/wheel.py ${SCRATCH}/moved ${SCRATCH} ${version} 2.17)
  file(GLOB wheel ${SCRATCH}/fluxgs-${version}-py3-none-manylinux_2_17_*.whl)
  run(${PYTHON} -m pip install --quiet --no-index --disable-pip-version-check
      --target ${SCRATCH}/environment ${wheel})
  run(${SCRATCH}/environment/bin/fluxgs --version)
endif()
