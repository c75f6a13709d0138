# Every program that the renderer makes: its name, its shaders, the defines they get. One line each.
# The build writes them as the driver gets them (CMakeLists.txt beside); glslangValidator and
# tools/adreno compile these files, and programs_test fails if the renderer makes one that is missing
# here or does not make one that is listed. For the size of a batch the default stands for all.
fluxgs_program(project project.comp)
fluxgs_program(project_half project.comp DEFINES PROJECTED_SPLAT_HALF)
fluxgs_program(project_compensated project.comp DEFINES COMPENSATED)
fluxgs_program(project_half_compensated project.comp DEFINES PROJECTED_SPLAT_HALF COMPENSATED)
fluxgs_program(draw_arguments draw_arguments.comp DEFINES "BATCH 128")
fluxgs_program(gather gather.comp DEFINES "BATCH 128")
fluxgs_program(gather_half gather.comp DEFINES "BATCH 128" PROJECTED_SPLAT_HALF)
fluxgs_program(splat splat.vert splat.frag DEFINES "BATCH 128")
fluxgs_program(splat_half splat.vert splat.frag DEFINES "BATCH 128" PROJECTED_SPLAT_HALF)
fluxgs_program(splat_texture splat.vert splat.frag DEFINES "BATCH 128" TEXTURE_FETCH)
fluxgs_program(splat_half_texture splat.vert splat.frag DEFINES "BATCH 128" PROJECTED_SPLAT_HALF TEXTURE_FETCH)
# Without compute shaders, as the drivers of ES 3.1 that get them wrong take them, and those of ES 3.0.
foreach(version 310 300)
  foreach(half "" PROJECTED_SPLAT_HALF)
    string(REPLACE PROJECTED_SPLAT_HALF _half name "${half}")
    fluxgs_program(project${name}_fragment_${version} screen.vert project.frag VERSION ${version} DEFINES ${half})
    fluxgs_program(project${name}_compensated_fragment_${version} screen.vert project.frag
                   VERSION ${version} DEFINES ${half} COMPENSATED)
    fluxgs_program(project${name}_point_${version} project_point.vert project_point.frag
                   VERSION ${version} DEFINES ${half})
    fluxgs_program(project${name}_compensated_point_${version} project_point.vert project_point.frag
                   VERSION ${version} DEFINES ${half} COMPENSATED)
    fluxgs_program(splat${name}_fragment_${version} splat.vert splat.frag
                   VERSION ${version} DEFINES "BATCH 128" ${half} PROJECTED_BY_FRAGMENTS)
  endforeach()
endforeach()
fluxgs_program(layer screen.vert layer.frag)
fluxgs_program(layer_300 screen.vert layer.frag VERSION 300)
fluxgs_program(resolve_300 screen.vert resolve.frag VERSION 300)
fluxgs_program(resolve_enlarge_300 screen.vert resolve.frag VERSION 300 DEFINES ENLARGE)
foreach(half "" PROJECTED_SPLAT_HALF)
  string(REPLACE PROJECTED_SPLAT_HALF _half name "${half}")
  fluxgs_program(splat${name}_front splat.vert splat.frag DEFINES "BATCH 128" ${half} FRONT_TO_BACK)
endforeach()
fluxgs_program(mark screen.vert mark.frag DEFINES MARK)
fluxgs_program(mark_background screen.vert mark.frag)
fluxgs_program(resolve screen.vert resolve.frag)
fluxgs_program(resolve_enlarge screen.vert resolve.frag DEFINES ENLARGE)
foreach(bits RANGE 4 8)
  foreach(step count scan scatter)
    fluxgs_program(sort_${step}_${bits} sort_${step}.comp DEFINES "RADIX_BITS ${bits}")
    fluxgs_program(sort_${step}_${bits}_first sort_${step}.comp DEFINES "RADIX_BITS ${bits}" FIRST_PASS)
  endforeach()
  fluxgs_program(sort_scatter_${bits}_last sort_scatter.comp DEFINES "RADIX_BITS ${bits}" LAST_PASS)
endforeach()
