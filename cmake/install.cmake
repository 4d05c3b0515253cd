# Installation rules and the exported package: find_package(gpsrecon), then link gpsrecon::gpsrecon.
include(CMakePackageConfigHelpers)

# The headers of the library's interface, in namespace gpsrecon. All others are details, in namespace
# gpsrecon::internal, and stay behind.
set(GPSRECON_PUBLIC_HEADERS
  clop/normals.h
  clop/orientation.h
  clop/particles.h
  clop/project.h
  core/connectivity.h
  core/error.h
  core/frame.h
  core/in_frame.h
  core/length.h
  core/mesh.h
  core/mesh_topology.h
  core/mixture.h
  core/options.h
  core/point_cloud.h
  core/prepared_cloud.h
  core/repair_topology.h
  core/resource_usage.h
  core/run_context.h
  core/scale.h
  core/surface_rules.h
  core/sym3.h
  core/vec.h
  core/version.h
  fit/fit.h
  gps/edit.h
  gps/evaluate.h
  gps/infer.h
  gps/subdivide.h
  gps/surface_weights.h
  hem/hem.h
  io/io.h
  measure/align.h
  measure/compare.h
  measure/distance.h
  measure/mesh_measures.h
  measure/statistics.h
  pipeline/point_normals.h
  pipeline/projection.h
  pipeline/reconstruct.h
  report/heatmap.h
  report/html_report.h
  report/report.h
  triangulate/triangulate.h)
foreach(header IN LISTS GPSRECON_PUBLIC_HEADERS)
  cmake_path(GET header PARENT_PATH stage)
  install(FILES lib/${header} DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}/gpsrecon/${stage})
endforeach()

# gpsrecon_installed builds what the installation copies, and no more.
add_custom_target(gpsrecon_installed DEPENDS gpsrecon)
install(TARGETS gpsrecon EXPORT gpsrecon ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
if(TARGET gpsrecon_cli)
  add_dependencies(gpsrecon_installed gpsrecon_cli)
  install(TARGETS gpsrecon_cli RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()
if(TARGET gpsrecon_pcd)
  add_dependencies(gpsrecon_installed gpsrecon_pcd)
  install(TARGETS gpsrecon_pcd LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/gpsrecon)
endif()
install(FILES docs/reference/report.schema.json DESTINATION ${CMAKE_INSTALL_DATADIR}/gpsrecon)
install(FILES LICENSE README.md CHANGELOG.md THIRD_PARTY.md DESTINATION ${CMAKE_INSTALL_DOCDIR})

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/gpsrecon)
install(EXPORT gpsrecon FILE gpsreconTargets.cmake NAMESPACE gpsrecon:: DESTINATION ${package})
configure_package_config_file(cmake/gpsreconConfig.cmake.in ${PROJECT_BINARY_DIR}/gpsreconConfig.cmake
  INSTALL_DESTINATION ${package} NO_SET_AND_CHECK_MACRO NO_CHECK_REQUIRED_COMPONENTS_MACRO)
# Before 1.0 a minor version may change the interface.
write_basic_package_version_file(${PROJECT_BINARY_DIR}/gpsreconConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/gpsreconConfig.cmake ${PROJECT_BINARY_DIR}/gpsreconConfigVersion.cmake
  DESTINATION ${package})
