# The library for other programs, kerf::kerf: one shared library with what the headers of include/kerf declare.
file(GLOB kerf_public_headers CONFIGURE_DEPENDS ${PROJECT_SOURCE_DIR}/include/kerf/*.h)
# The folders that implement public headers, completely. What else they need is linked as needed.
set(kerf_public_folders core material grid vdb models segmentation tool force paper effects path_sim slab_sim hand_sim undo library)
add_library(kerf_shared SHARED ${kerf_public_headers} ${PROJECT_SOURCE_DIR}/packaging/exports.map)
set_target_properties(kerf_shared PROPERTIES OUTPUT_NAME kerf EXPORT_NAME kerf LINKER_LANGUAGE CXX VERSION ${PROJECT_VERSION}
                      SOVERSION ${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR}
                      LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR} LINK_DEPENDS ${PROJECT_SOURCE_DIR}/packaging/exports.map)
add_library(kerf::kerf ALIAS kerf_shared)
target_link_options(kerf_shared PRIVATE LINKER:--version-script=${PROJECT_SOURCE_DIR}/packaging/exports.map LINKER:--no-undefined
                    LINKER:-Bsymbolic-functions LINKER:--gc-sections)
foreach(folder ${kerf_public_folders})
  if(TARGET kerf_${folder})
    get_target_property(type kerf_${folder} TYPE)
    if(type STREQUAL "STATIC_LIBRARY")
      list(APPEND kerf_whole $<TARGET_FILE:kerf_${folder}>)
      set_property(TARGET kerf_shared APPEND PROPERTY LINK_DEPENDS $<TARGET_FILE:kerf_${folder}>)
    endif()
    target_link_libraries(kerf_shared PRIVATE kerf_${folder})
  endif()
endforeach()
target_link_options(kerf_shared PRIVATE LINKER:--whole-archive ${kerf_whole} LINKER:--no-whole-archive)
target_compile_features(kerf_shared INTERFACE cxx_std_20)
target_include_directories(kerf_shared INTERFACE $<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:include>)

# For programs that want to know whether their own force laws and effects use heap memory in a tick.
if(NOT KERF_SANITIZE)
  add_library(kerf_heap_guard_library STATIC $<TARGET_OBJECTS:kerf_heap_guard>)
  set_target_properties(kerf_heap_guard_library PROPERTIES OUTPUT_NAME kerf_heap_guard EXPORT_NAME heap_guard LINKER_LANGUAGE CXX)
  target_link_libraries(kerf_heap_guard_library INTERFACE kerf_shared)
  # Makes the linker take the replacements of malloc even if nothing else refers to them first.
  target_link_options(kerf_heap_guard_library INTERFACE LINKER:--undefined=malloc)
  set(kerf_installed kerf_heap_guard_library)
endif()

include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
install(TARGETS kerf_shared ${kerf_installed} EXPORT kerf
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
configure_file(${PROJECT_SOURCE_DIR}/packaging/kerf.pc.in ${PROJECT_BINARY_DIR}/kerf.pc @ONLY)
install(FILES ${PROJECT_BINARY_DIR}/kerf.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig COMPONENT library-dev)
