# powbench_late(TARGET DEFINITION LIBRARY): LIBRARY is loaded when it is first used (core/late_library.h), by the name that DEFINITION gets.
# What a package depends on is found by lib/late, which is linked to all of them and goes nowhere.
file(WRITE ${PROJECT_BINARY_DIR}/late.cpp "")
add_library(powbench_late MODULE EXCLUDE_FROM_ALL ${PROJECT_BINARY_DIR}/late.cpp)
target_link_options(powbench_late PRIVATE LINKER:--no-as-needed)
function(powbench_late target definition library)
  execute_process(COMMAND ${CMAKE_READELF} -d ${library} OUTPUT_VARIABLE dynamic ERROR_QUIET)
  if(NOT dynamic MATCHES "SONAME[^[]*\\[([^]]+)\\]")
    message(FATAL_ERROR "${library}: no shared library; install the one that its package names")
  endif()
  target_compile_definitions(${target} PRIVATE "${definition}=\"${CMAKE_MATCH_1}\"")
  target_link_libraries(powbench_late PRIVATE ${library})
endfunction()
