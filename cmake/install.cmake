# What `cmake --install` puts where. The Debian packages take their parts from the same tree (debian/*.install).
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
option(POWBENCH_SITE "Build the documentation as a site, with mkdocs" OFF)
set(POWBENCH_PYTHON_DIR lib/python3/dist-packages CACHE STRING "Where the Python package is installed")

install(TARGETS powbench RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(TARGETS powbench_contactor LIBRARY DESTINATION lib/powbench)  # found from bin/ (host/export/fmu.cpp)
install(DIRECTORY ${PROJECT_BINARY_DIR}/manual/man/ DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(FILES ${PROJECT_BINARY_DIR}/manual/completions/powbench
        DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions)
install(DIRECTORY scenes DESTINATION ${CMAKE_INSTALL_DATADIR}/powbench)
install(FILES packaging/powbench-serve.service DESTINATION lib/systemd/system)
install(FILES packaging/70-powbench.rules DESTINATION lib/udev/rules.d)

if(POWBENCH_PYTHON)
  install(TARGETS powbench_python LIBRARY DESTINATION ${POWBENCH_PYTHON_DIR}/powbench)
  install(DIRECTORY python/powbench DESTINATION ${POWBENCH_PYTHON_DIR} FILES_MATCHING PATTERN "*.py" PATTERN "*.pyi"
          PATTERN "py.typed" PATTERN "__pycache__" EXCLUDE)
endif()

# The library: records to events, and the simulator. find_package(powbench), then powbench::dsp and powbench::sim.
install(DIRECTORY core dsp sim DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/powbench FILES_MATCHING PATTERN "*.h")
foreach(part options core dsp sim)
  set_target_properties(powbench_${part} PROPERTIES EXPORT_NAME ${part})
endforeach()
install(TARGETS powbench_options powbench_core powbench_dsp powbench_sim EXPORT powbench
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/powbench)
install(EXPORT powbench NAMESPACE powbench:: FILE powbenchTargets.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/powbench)
configure_package_config_file(cmake/powbenchConfig.cmake.in ${PROJECT_BINARY_DIR}/powbenchConfig.cmake
  INSTALL_DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/powbench)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/powbenchConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/powbenchConfig.cmake ${PROJECT_BINARY_DIR}/powbenchConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/powbench)
