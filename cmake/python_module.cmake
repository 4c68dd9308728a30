# python_module.cmake: modules for the Python host, made with nanobind and put where the package looks for them.
if(NOT Python_EXECUTABLE)
  set(Python_EXECUTABLE ${PROJECT_SOURCE_DIR}/.venv/bin/python)
endif()
find_package(Python 3.11 REQUIRED COMPONENTS Interpreter Development.Module)
execute_process(COMMAND ${Python_EXECUTABLE} -m nanobind --cmake_dir OUTPUT_VARIABLE nanobind_ROOT
                OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
find_package(nanobind CONFIG REQUIRED)
set(GONIO_PYTHON_TO ${PROJECT_SOURCE_DIR}/host/gonio CACHE PATH "the package gonio that the modules go into")

# gonio_python_module(NAME PACKAGE SOURCES...): the module gonio.PACKAGE.NAME.
function(gonio_python_module name package)
  nanobind_add_module(${name} NB_STATIC NOMINSIZE ${ARGN})
  # nanobind's headers and sources are not held to our warnings.
  target_compile_options(nanobind-static PRIVATE -w)
  set_target_properties(nanobind-static ${name} PROPERTIES SYSTEM ON)
  set_target_properties(${name} PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${GONIO_PYTHON_TO}/${package})
endfunction()
