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

run("The program cannot be configured" ${CMAKE_COMMAND} -S ${CMAKE_CURRENT_LIST_DIR}/consumer -B ${build}
  -G ${GENERATOR} -D CMAKE_BUILD_TYPE=${BUILD_TYPE} -D CMAKE_CXX_COMPILER=${CXX_COMPILER}
  "-DCMAKE_CXX_FLAGS=${CXX_FLAGS}" -D CMAKE_PREFIX_PATH=${stage} -D INCLUDE_DIR=${stage}/include)
run("The program cannot be built" ${CMAKE_COMMAND} --build ${build})
run("The program fails" ${build}/consumer)
message("${output}")

find_program(program gpsrecon PATHS ${stage}/bin NO_DEFAULT_PATH)
if(program)
  run("The installed command line program fails" ${program} --version)
  string(FIND "${output}" "${VERSION}" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "gpsrecon --version does not name version ${VERSION}: ${output}")
  endif()
endif()
