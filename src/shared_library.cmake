# The libraries for other programs, each with the folders that implement its public headers, completely. What else they
# need is linked as needed. A program links one of them: kerf::kerf contains what kerf::core has.
set(kerf_core_folders core material grid vdb models tool force paper effects path_sim slab_sim hand_sim undo)
file(GLOB kerf_public_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/kerf/*.h)
set(kerf_exports ${PROJECT_SOURCE_DIR}/packaging/exports.map)
function(kerf_shared_library name target output)
  add_library(${target} SHARED ${kerf_public_headers} ${kerf_exports})
  add_library(kerf::${name} ALIAS ${target})
  set_target_properties(${target} PROPERTIES OUTPUT_NAME ${output} EXPORT_NAME ${name} LINKER_LANGUAGE CXX VERSION ${PROJECT_VERSION}
                        SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
                        LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR} LINK_DEPENDS ${kerf_exports})
  # Force laws and effects of one's own are known to one library, so CMake refuses a target that links both.
  set_target_properties(${target} PROPERTIES INTERFACE_KERF_LIBRARY ${name} COMPATIBLE_INTERFACE_STRING KERF_LIBRARY)
  target_link_options(${target} PRIVATE LINKER:--version-script=${kerf_exports} LINKER:--no-undefined LINKER:-Bsymbolic-functions
                      LINKER:--gc-sections LINKER:--as-needed)
  foreach(folder ${ARGN})
    get_target_property(type kerf_${folder} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
      list(APPEND whole $<TARGET_FILE:kerf_${folder}>)
    endif()
    target_link_libraries(${target} PRIVATE kerf_${folder})
  endforeach()
  set_property(TARGET ${target} APPEND PROPERTY LINK_DEPENDS ${whole})
  target_link_options(${target} PRIVATE LINKER:--whole-archive ${whole} LINKER:--no-whole-archive)
  target_compile_features(${target} INTERFACE cxx_std_20)
  target_include_directories(${target} INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)
endfunction()
kerf_shared_library(core kerf_shared_core kerf_core ${kerf_core_folders})
kerf_shared_library(kerf kerf_shared kerf ${kerf_core_folders} segmentation library)

# For programs that want to know whether their own force laws and effects use heap memory in a tick.
if(NOT KERF_SANITIZE)
  add_library(kerf_heap_guard_library STATIC $<TARGET_OBJECTS:kerf_heap_guard>)
  set_target_properties(kerf_heap_guard_library PROPERTIES OUTPUT_NAME kerf_heap_guard EXPORT_NAME heap_guard LINKER_LANGUAGE CXX)
  # Makes the linker take the replacements of malloc even if nothing else refers to them first.
  target_link_options(kerf_heap_guard_library INTERFACE LINKER:--undefined=malloc)
  set(kerf_installed kerf_heap_guard_library)
endif()

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
install(TARGETS kerf_shared kerf_shared_core ${kerf_installed} EXPORT kerf
        LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library NAMELINK_COMPONENT library-dev
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR} COMPONENT library-dev)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/include/kerf DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT library-dev)
install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/doc/libkerf-dev COMPONENT library-dev
        PATTERN "*.py" EXCLUDE PATTERN "notebooks" EXCLUDE)
install(EXPORT kerf NAMESPACE kerf:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kerf FILE kerfTargets.cmake COMPONENT library-dev)
write_basic_package_version_file(${PROJECT_BINARY_DIR}/kerfConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_SOURCE_DIR}/packaging/kerfConfig.cmake ${PROJECT_BINARY_DIR}/kerfConfigVersion.cmake
        DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/kerf COMPONENT library-dev)
# The file names its prefix relative to itself, so that the installation can be moved.
file(RELATIVE_PATH kerf_pc_prefix ${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_LIBDIR}/pkgconfig ${CMAKE_INSTALL_PREFIX})
string(REGEX REPLACE "/$" "" kerf_pc_prefix "${kerf_pc_prefix}")
foreach(kerf_pc_name kerf kerf_core)
  configure_file(${PROJECT_SOURCE_DIR}/packaging/kerf.pc.in ${PROJECT_BINARY_DIR}/${kerf_pc_name}.pc @ONLY)
  install(FILES ${PROJECT_BINARY_DIR}/${kerf_pc_name}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT library-dev)
endforeach()
