# `cmake --install`: component runtime is what a session needs, development what find_package(vr_oos) needs.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

# Programs find each other and version.txt in their own folder, so /usr/bin gets only a link.
set(program_folder "${CMAKE_INSTALL_LIBEXECDIR}/vr-oos")
install(TARGETS oos device_bridge haptic_node physics_node haptic_physics_node logic_node visual_node DESTINATION "${program_folder}" COMPONENT runtime)
if(VR_OOS_RAYS)
  install(TARGETS rt_visual_node rt_worker DESTINATION "${program_folder}" COMPONENT runtime)
endif()
install(FILES "${CMAKE_BINARY_DIR}/bin/version.txt" DESTINATION "${program_folder}" COMPONENT runtime OPTIONAL)
file(RELATIVE_PATH oos_from_path "/${CMAKE_INSTALL_BINDIR}" "/${program_folder}/oos")
file(MAKE_DIRECTORY "${CMAKE_BINARY_DIR}/install")
file(CREATE_LINK "${oos_from_path}" "${CMAKE_BINARY_DIR}/install/oos" SYMBOLIC)
install(FILES "${CMAKE_BINARY_DIR}/install/oos" DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT runtime)
install(DIRECTORY "${CMAKE_SOURCE_DIR}/scenarios" DESTINATION "${CMAKE_INSTALL_DATADIR}/vr-oos" COMPONENT runtime
  PATTERN tools EXCLUDE PATTERN "*.sh" EXCLUDE)

# Libraries, in a folder of headers as the sources have them: #include "vps/...".
set(header_folder "${CMAKE_INSTALL_INCLUDEDIR}/vr_oos")
set(package_folder "${CMAKE_INSTALL_LIBDIR}/cmake/vr_oos")
set_target_properties(vr_oos_flags PROPERTIES EXPORT_NAME flags)
install(TARGETS vr_oos_flags core proto vps physics bus EXPORT vr_oos
  ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}/vr_oos" COMPONENT development
  INCLUDES DESTINATION "${header_folder}")
foreach(room core vps physics bus)
  install(DIRECTORY "${CMAKE_SOURCE_DIR}/libs/${room}" DESTINATION "${header_folder}" COMPONENT development
    FILES_MATCHING PATTERN "*.hpp" PATTERN testing EXCLUDE PATTERN oracle EXCLUDE PATTERN "*_testing.hpp" EXCLUDE)
endforeach()
# All that a device as a C library needs (docs/howto/own-device.md).
install(FILES "${CMAKE_SOURCE_DIR}/libs/device/plugin.h" DESTINATION "${header_folder}/device" COMPONENT development)
install(DIRECTORY "${CMAKE_BINARY_DIR}/generated/" DESTINATION "${header_folder}" COMPONENT development FILES_MATCHING PATTERN "*.h" PATTERN "*.hpp")
install(EXPORT vr_oos NAMESPACE vr_oos:: FILE vr_oosTargets.cmake DESTINATION "${package_folder}" COMPONENT development)
configure_package_config_file("${CMAKE_CURRENT_LIST_DIR}/vr_oosConfig.cmake.in" "${CMAKE_BINARY_DIR}/install/vr_oosConfig.cmake"
  INSTALL_DESTINATION "${package_folder}")
write_basic_package_version_file("${CMAKE_BINARY_DIR}/install/vr_oosConfigVersion.cmake" COMPATIBILITY SameMinorVersion)
install(FILES "${CMAKE_BINARY_DIR}/install/vr_oosConfig.cmake" "${CMAKE_BINARY_DIR}/install/vr_oosConfigVersion.cmake"
  DESTINATION "${package_folder}" COMPONENT development)

# `./dev package`: vr-oos to run, vr-oos-dev to compile against.
set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME vr-oos)
set(CPACK_PACKAGE_VERSION "${PROJECT_VERSION}")
set(CPACK_PACKAGE_CONTACT "VR-OOS developers")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Simulator for telerobotic on-orbit servicing with haptic feedback")
set(CPACK_PACKAGING_INSTALL_PREFIX "/usr")
set(CPACK_STRIP_FILES ON)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL runtime development)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME vr-oos)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
# Packages that no program links but that are loaded, started or read at run time.
set(CPACK_DEBIAN_RUNTIME_PACKAGE_DEPENDS "libgl1, libgl1-mesa-dri, xvfb, fonts-dejavu-core")
set(CPACK_DEBIAN_RUNTIME_PACKAGE_RECOMMENDS "ffmpeg")  # videos, the film of a report
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME vr-oos-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "cppzmq-dev, libbullet-dev, libexpected-dev, libglm-dev, libopenmesh-dev, \
libprotobuf-dev, libsodium-dev, libtinygltf-dev, libxxhash-dev, libzmq3-dev, pkg-config, zlib1g-dev")
include(CPack)
