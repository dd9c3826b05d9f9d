# After a whole build, `cpack --config build/release/CPackConfig.cmake` makes the Debian packages borelli (program, manual page, sample scenes),
# libborelli-dev (headers, static libraries, CMake files) and, where the Python module is built, python3-borelli.
install(DIRECTORY samples/ DESTINATION ${CMAKE_INSTALL_DATADIR}/borelli/samples COMPONENT program FILES_MATCHING PATTERN "*.toml")
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/borelli RENAME copyright COMPONENT program)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/libborelli-dev RENAME copyright COMPONENT library)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The borelli developers <developers@borelli.invalid>")
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program library)
set(CPACK_STRIP_FILES ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_COMPRESSION_TYPE zstd)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_COMPONENT_PROGRAM_DESCRIPTION "${PROJECT_DESCRIPTION}\nSegments a scan of a person, integrates each part's mass and inertia, builds a skeleton,\nmoves it by the laws of mechanics, and reports.")
set(CPACK_COMPONENT_LIBRARY_DESCRIPTION "Headers and static libraries of borelli\nFor programs that segment scans, integrate inertia or simulate multibody systems.")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_NAME borelli)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS ffmpeg)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libborelli-dev)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
# what borelliConfig.cmake looks for
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS
    "borelli (= ${PROJECT_VERSION}), libeigen3-dev, zlib1g-dev, libbz2-dev, libexpat1-dev, libqhull-dev, libfcl-dev, libexpected-dev, libfmt-dev, nlohmann-json3-dev, libtomlplusplus-dev, libsundials-dev, libisal-dev, libssl-dev, libtinygltf-dev, pkg-config")
if(TARGET python_module)
  install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/python3-borelli RENAME copyright COMPONENT python3)
  list(APPEND CPACK_COMPONENTS_ALL python3)
  set(CPACK_COMPONENT_PYTHON3_DESCRIPTION "borelli in Python\nThe module borelli: scans, inertia tables, scenes, motions and charts as NumPy arrays.")
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_NAME python3-borelli)
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_SHLIBDEPS ON)
  # an extension module is made for one version of Python
  math(EXPR next_python "${Python_VERSION_MINOR} + 1")
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_DEPENDS
      "borelli (= ${PROJECT_VERSION}), python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next_python}), python3-numpy")
  set(CPACK_DEBIAN_PYTHON3_PACKAGE_RECOMMENDS python3-pandas)
endif()
include(CPack)
