# Tells find_package(pktrt VERSION) whether this pktrt will do. While the major version is 0, a new minor version may ask for
# changes in programs (Versions in examples/manual.md): 0.19.3 will do for those that ask for 0.19 or 0.19.1, not for 0.18 or 0.20. From
# 1.0 on the major version decides. A range, such as 0.18...0.30, is taken literally. The version is that of the header.
get_filename_component(_pktrt_here "${CMAKE_CURRENT_LIST_DIR}" REALPATH)
set(_pktrt_header "${_pktrt_here}/../../pktrt.h")
if(NOT EXISTS "${_pktrt_header}")
  set(_pktrt_header "${_pktrt_here}/../../../include/pktrt.h")
endif()

file(STRINGS "${_pktrt_header}" _pktrt_number LIMIT_COUNT 1 REGEX "^#define PKTRT_VERSION [0-9]+")
string(REGEX REPLACE "^#define PKTRT_VERSION ([0-9]+).*" "\\1" _pktrt_number "${_pktrt_number}")
math(EXPR _pktrt_major "${_pktrt_number} / 10000")
math(EXPR _pktrt_minor "${_pktrt_number} / 100 % 100")
math(EXPR _pktrt_patch "${_pktrt_number} % 100")
set(PACKAGE_VERSION ${_pktrt_major}.${_pktrt_minor}.${_pktrt_patch})

set(PACKAGE_VERSION_COMPATIBLE FALSE)
if(PACKAGE_FIND_VERSION_RANGE)
  if(PACKAGE_VERSION VERSION_GREATER_EQUAL PACKAGE_FIND_VERSION_MIN AND
      (PACKAGE_VERSION VERSION_LESS PACKAGE_FIND_VERSION_MAX OR
        (PACKAGE_VERSION VERSION_EQUAL PACKAGE_FIND_VERSION_MAX AND PACKAGE_FIND_VERSION_RANGE_MAX STREQUAL "INCLUDE")))
    set(PACKAGE_VERSION_COMPATIBLE TRUE)
  endif()
elseif(PACKAGE_VERSION VERSION_GREATER_EQUAL PACKAGE_FIND_VERSION AND PACKAGE_FIND_VERSION_MAJOR EQUAL _pktrt_major AND
    (_pktrt_major GREATER 0 OR PACKAGE_FIND_VERSION_COUNT LESS 2 OR PACKAGE_FIND_VERSION_MINOR EQUAL _pktrt_minor))
  set(PACKAGE_VERSION_COMPATIBLE TRUE)
  if(PACKAGE_VERSION VERSION_EQUAL PACKAGE_FIND_VERSION)
    set(PACKAGE_VERSION_EXACT TRUE)
  endif()
endif()
