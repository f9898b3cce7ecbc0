# talus_find_mrpt(PART...): libraries of MRPT as mrpt::PART. From 3.0 on the package of mrpt::PART is mrpt_PART, and its
# target mrpt::mrpt_PART.
macro(talus_find_mrpt)
  foreach(part ${ARGN})
    find_package(mrpt_${part} QUIET)
    if(NOT mrpt_${part}_FOUND)
      find_package(mrpt-${part} REQUIRED)
    elseif(NOT TARGET mrpt::${part})
      add_library(mrpt::${part} ALIAS mrpt::mrpt_${part})
    endif()
  endforeach()
endmacro()
