# Makes two targets:
#   pktrt::pktrt   the header alone. One file of the program defines PKTRT_IMPLEMENTATION: compile it with -O2 in Debug builds.
#   pktrt::static  the header, and its implementation as a static library. No file of the program defines PKTRT_IMPLEMENTATION. The
#                  library is built only if a target that is built links it. Projects without C compile it as C++; those with
#                  neither have no such target.
# Two lists may be set before:
#   PKTRT_SWITCHES         macros for pktrt::static and for all that link it, such as "PKTRT_NO_RENDER;PKTRT_NO_MOTION"
#   PKTRT_COMPILE_OPTIONS  how to compile pktrt::static, behind the options of the build type: -O2, whatever that is. With
#                          -fsanitize= set it to -O0: that compiles in a fraction of the time.
#
# This file works in the project's folder and where `make install` puts it, and the folder may be moved afterwards.
if(TARGET pktrt::pktrt)
  return()
endif()

# The header is two folders above this file in the project's folder, and in `include` beside `lib` where it is installed. The real
# path: on many systems /lib is a link to /usr/lib.
get_filename_component(_pktrt_here "${CMAKE_CURRENT_LIST_DIR}" REALPATH)
get_filename_component(_pktrt_include "${_pktrt_here}/../.." ABSOLUTE)
if(NOT EXISTS "${_pktrt_include}/pktrt.h")
  get_filename_component(_pktrt_include "${_pktrt_here}/../../../include" ABSOLUTE)
endif()
if(NOT EXISTS "${_pktrt_include}/pktrt.h")
  message(FATAL_ERROR "pktrt: there is no ${_pktrt_include}/pktrt.h, which belongs to ${CMAKE_CURRENT_LIST_FILE}")
endif()

# Imported targets may be linked by libraries that a project exports, and their folder gives no warnings.
add_library(pktrt::pktrt INTERFACE IMPORTED GLOBAL)
set_target_properties(pktrt::pktrt PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${_pktrt_include}")
if(NOT WIN32 OR MINGW)
  set_target_properties(pktrt::pktrt PROPERTIES INTERFACE_LINK_LIBRARIES m)
endif()

get_property(_pktrt_languages GLOBAL PROPERTY ENABLED_LANGUAGES)
set(_pktrt_source)
if("C" IN_LIST _pktrt_languages)
  set(_pktrt_source "${CMAKE_CURRENT_BINARY_DIR}/pktrt_static.c")
elseif("CXX" IN_LIST _pktrt_languages)
  set(_pktrt_source "${CMAKE_CURRENT_BINARY_DIR}/pktrt_static.cpp")
endif()
if(_pktrt_source)
  # An unchanged file keeps its time, so that configuring anew compiles nothing.
  set(_pktrt_text "#define PKTRT_IMPLEMENTATION\n#include <pktrt.h>\n")
  set(_pktrt_before)
  if(EXISTS "${_pktrt_source}")
    file(READ "${_pktrt_source}" _pktrt_before)
  endif()
  if(NOT _pktrt_before STREQUAL _pktrt_text)
    file(WRITE "${_pktrt_source}" "${_pktrt_text}")
  endif()

  add_library(pktrt_static STATIC EXCLUDE_FROM_ALL "${_pktrt_source}")
  add_library(pktrt::static ALIAS pktrt_static)
  target_link_libraries(pktrt_static PUBLIC pktrt::pktrt)
  target_compile_definitions(pktrt_static PUBLIC ${PKTRT_SWITCHES})
  # A shared library may link it, and does not export it.
  set_target_properties(pktrt_static PROPERTIES C_STANDARD 99 CXX_STANDARD 11 POSITION_INDEPENDENT_CODE ON
    C_VISIBILITY_PRESET hidden CXX_VISIBILITY_PRESET hidden)
  if(DEFINED PKTRT_COMPILE_OPTIONS)
    target_compile_options(pktrt_static PRIVATE ${PKTRT_COMPILE_OPTIONS})
  elseif(NOT MSVC) # which is untested, and whose /O2 bears no /RTC1 of Debug builds
    target_compile_options(pktrt_static PRIVATE -O2)
  endif()
endif()
