# Run by ctest; see CMakeLists.txt beside this file for the variables.
set(stage ${WORK_DIR}/stage)
set(build ${WORK_DIR}/build)
file(REMOVE_RECURSE ${WORK_DIR})

function(run what)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE result OUTPUT_VARIABLE output ERROR_VARIABLE output)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${what}:\n${output}")
  endif()
  set(output "${output}" PARENT_SCOPE)
endfunction()

run("The installation failed" ${CMAKE_COMMAND} --install ${BUILD_DIR} --prefix ${stage})

# An installation knows nothing of where it was built.
file(GLOB_RECURSE package_files ${stage}/*.cmake)
if(NOT package_files)
  message(FATAL_ERROR "No package files were installed")
endif()
foreach(file IN LISTS package_files)
  file(READ ${file} text)
  foreach(folder ${SOURCE_DIR} ${BUILD_DIR})
    string(FIND "${text}" "${folder}/" at)
    if(NOT at EQUAL -1)
      message(FATAL_ERROR "${file} names the folder ${folder}")
    endif()
  endforeach()
endforeach()

# Public headers show the standard library, Eigen and each other, nothing else.
file(GLOB_RECURSE headers ${stage}/include/*.h)
foreach(header IN LISTS headers)
  file(STRINGS ${header} includes REGEX "^#include ")
  foreach(line IN LISTS includes)
    if(NOT line MATCHES "^#include <(gpsrecon/[a-z_]+/[a-z0-9_]+\\.h|Eigen/[A-Z][A-Za-z]+|[a-z_]+)>")
      message(FATAL_ERROR "${header}: ${line}")
    endif()
  endforeach()
endforeach()

function(build_program source)
  file(WRITE ${WORK_DIR}/main.cpp "${source}")
  run("The program cannot be configured" ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/consumer -B ${build}
    -G ${GENERATOR} -D CMAKE_BUILD_TYPE=${BUILD_TYPE} -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
    "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}" -D CMAKE_PREFIX_PATH=${stage} -D INCLUDE_DIR=${stage}/include
    -D MAIN=${WORK_DIR}/main.cpp)
  run("The program cannot be built" ${CMAKE_COMMAND} --build ${build})
endfunction()

# The programs are those that README and guide show: the same one, and in the guide another.
set(block "```cpp\n([^`]+)```")
file(READ ${SOURCE_DIR}/README.md readme)
string(REGEX MATCH "${block}" found "${readme}")
set(reconstructs "${CMAKE_MATCH_1}")
file(READ ${SOURCE_DIR}/docs/guide/library.md guide)
string(REGEX MATCH "${block}" found "${guide}")
if(NOT "${CMAKE_MATCH_1}" STREQUAL "${reconstructs}")
  message(FATAL_ERROR "README.md and docs/guide/library.md show different programs")
endif()
string(REPLACE "${found}" "" guide "${guide}")
string(REGEX MATCH "${block}" found "${guide}")
set(evaluates "${CMAKE_MATCH_1}")

build_program("${reconstructs}")
run("The program fails" ${build}/consumer ${BUILD_DIR}/datasets/example.ply ${WORK_DIR}/surface.ply)
file(STRINGS ${WORK_DIR}/surface.ply faces REGEX "^element face [1-9]" LIMIT_COUNT 1)
if(NOT faces)
  message(FATAL_ERROR "The program wrote no faces")
endif()
build_program("${evaluates}")
run("The program of the guide fails" ${build}/consumer ${SOURCE_DIR}/tests/corpus/covmesh_two_triangles.ply)
if(NOT output)
  message(FATAL_ERROR "The program of the guide printed nothing")
endif()

find_program(program gpsrecon PATHS ${stage}/bin NO_DEFAULT_PATH)
if(program)
  run("The installed command line program fails" ${program} --version)
  string(FIND "${output}" "${VERSION}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "gpsrecon --version does not name version ${VERSION}: ${output}")
  endif()
endif()

# It finds its plug-in where the installation put it.
file(GLOB_RECURSE plugin ${stage}/*/gpsrecon_pcd.so)
if(program AND plugin)
  file(WRITE ${WORK_DIR}/three.pcd
    "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 3\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\n"
    "POINTS 3\nDATA ascii\n0 0 0\n1 0 0\n0 1 0\n")
  run("The installed program cannot read PCD files" ${program} info ${WORK_DIR}/three.pcd)
endif()
