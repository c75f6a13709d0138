# A kernel's object may define only symbols of its own instruction set's namespace: a shared inline
# function compiled for a newer processor could otherwise be the copy that the linker keeps for all.
# Run as: cmake -DNM=nm -DISA=avx2 -DOBJECTS=a.o;b.o -P kernel_symbols.cmake
foreach(object IN LISTS OBJECTS)
  execute_process(COMMAND ${NM} -C --defined-only ${object} OUTPUT_VARIABLE symbols
                  COMMAND_ERROR_IS_FATAL ANY)
  string(REPLACE "\n" ";" symbols "${symbols}")
  foreach(symbol IN LISTS symbols)
    if(symbol MATCHES " [TWVu] " AND NOT symbol MATCHES "fluxgs::${ISA}::|DW.ref|asan|ubsan")
      message(SEND_ERROR "${object} defines ${symbol}, which is not in fluxgs::${ISA}")
    endif()
  endforeach()
endforeach()
