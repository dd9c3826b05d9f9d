# `cpack --config build/release/CPackConfig.cmake` makes the Debian packages borelli (program, manual page, sample scenes) and
# libborelli-dev (headers, static libraries, CMake files).
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
set(CPACK_DEBIAN_PROGRAM_PACKAGE_RECOMMENDS xvfb)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_NAME libborelli-dev)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
# what borelliConfig.cmake looks for
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS
    "borelli (= ${PROJECT_VERSION}), libeigen3-dev, zlib1g-dev, libbz2-dev, libexpat1-dev, libqhull-dev, libexpected-dev, libfmt-dev, nlohmann-json3-dev, libtomlplusplus-dev, libsundials-dev, libisal-dev, libx11-dev, libssl-dev, libtinygltf-dev, pkg-config")
include(CPack)
