# CDT, constrained Delaunay triangulation (header only): its headers ship inside a source package of PyPI.
# Set CDT_INCLUDE_DIR to use a copy that is already there.
set(cdt_version 2.0.2)
set(cdt_sha256 303832cae14a5ce90bb4bc696274c8add0f1f0b9bd4edb943e24fd10417036c4)

if(NOT CDT_INCLUDE_DIR)
  set(cdt_folder ${CMAKE_BINARY_DIR}/cdt)
  set(cdt_archive ${cdt_folder}/pythoncdt-${cdt_version}.tar.gz)
  if(NOT EXISTS ${cdt_archive})
    find_package(Python 3.11 COMPONENTS Interpreter REQUIRED)
    execute_process(
      COMMAND ${Python_EXECUTABLE} -m pip download --quiet --disable-pip-version-check --no-deps
              --no-binary :all: --dest ${cdt_folder} pythoncdt==${cdt_version}
      RESULT_VARIABLE failed ERROR_VARIABLE cdt_error)
    if(failed)
      message(FATAL_ERROR "cannot get pythoncdt ${cdt_version} from PyPI (or set CDT_INCLUDE_DIR):\n${cdt_error}")
    endif()
  endif()
  file(SHA256 ${cdt_archive} found_sha256)
  if(NOT found_sha256 STREQUAL cdt_sha256)
    message(FATAL_ERROR "${cdt_archive}: SHA-256 ${found_sha256}, expected ${cdt_sha256}")
  endif()
  file(ARCHIVE_EXTRACT INPUT ${cdt_archive} DESTINATION ${cdt_folder})
  set(CDT_INCLUDE_DIR ${cdt_folder}/pythoncdt-${cdt_version}/CDT/CDT/include)
endif()

add_library(cdt INTERFACE)
target_include_directories(cdt SYSTEM INTERFACE ${CDT_INCLUDE_DIR})
