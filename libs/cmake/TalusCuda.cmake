# The CUDA language where it is wanted and there: sets TALUS_CUDA_ENABLED. Include from the directory that compiles .cu.
#
# TALUS_CUDA_ARCHITECTURES: what to compile for. "detect": the GPU of this machine, 90 where none answers; "all": every
# architecture from Turing on, and PTX for later ones; or a list as for CMAKE_CUDA_ARCHITECTURES.
set(TALUS_CUDA_ARCHITECTURES "detect" CACHE STRING "CUDA architectures: detect, all, or a list such as 86;90")

set(TALUS_CUDA_ENABLED OFF)
if(TALUS_WITH_CUDA)  # ON or AUTO
  if(NOT CMAKE_CUDA_COMPILER)
    find_program(TALUS_NVCC nvcc PATHS ENV CUDA_HOME /usr/local/cuda PATH_SUFFIXES bin)
    mark_as_advanced(TALUS_NVCC)
    if(TALUS_NVCC)
      set(CMAKE_CUDA_COMPILER "${TALUS_NVCC}")
    endif()
  endif()
  # One architecture while the compiler is tried; what is built says its own.
  if(NOT DEFINED CMAKE_CUDA_ARCHITECTURES)
    set(CMAKE_CUDA_ARCHITECTURES OFF)
  endif()
  include(CheckLanguage)
  check_language(CUDA)
  if(CMAKE_CUDA_COMPILER)
    enable_language(CUDA)
    find_package(CUDAToolkit REQUIRED)
    set(TALUS_CUDA_ENABLED ON)
  elseif(NOT TALUS_WITH_CUDA STREQUAL "AUTO")
    message(FATAL_ERROR "TALUS_WITH_CUDA is ON, but no CUDA compiler was found: set CMAKE_CUDA_COMPILER or CUDACXX")
  endif()
endif()
message(STATUS "talus: CUDA backend ${TALUS_CUDA_ENABLED}")

function(talus_cuda_architectures result)
  set(wanted "${TALUS_CUDA_ARCHITECTURES}")
  if(wanted STREQUAL "all")
    set(wanted 75-real 80-real 86-real 87-real 89-real 90-real 100-real 120)
  elseif(wanted STREQUAL "detect")
    execute_process(
      COMMAND nvidia-smi --query-gpu=compute_cap --format=csv,noheader
      OUTPUT_VARIABLE capabilities ERROR_QUIET RESULT_VARIABLE failed)
    string(REGEX MATCHALL "[0-9]+\\.[0-9]+" wanted "${capabilities}")
    string(REPLACE "." "" wanted "${wanted}")
    list(REMOVE_DUPLICATES wanted)
    if(failed OR NOT wanted)
      set(wanted 90)
    endif()
  endif()
  set(${result} "${wanted}" PARENT_SCOPE)
endfunction()

# talus_add_cuda_objects(TARGET SOURCES...): objects of the kernels, to be linked into a C++ library. Like all else
# without contraction and with exact division and roots: the same bits on every device.
function(talus_add_cuda_objects target)
  add_library(${target} OBJECT ${ARGN})
  talus_cuda_architectures(architectures)
  message(STATUS "talus: CUDA architectures ${architectures}")
  set_target_properties(${target} PROPERTIES
    CUDA_ARCHITECTURES "${architectures}" CUDA_STANDARD 17 CUDA_STANDARD_REQUIRED ON CUDA_EXTENSIONS OFF
    POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE
    -fmad=false -prec-div=true -prec-sqrt=true -ftz=false --expt-relaxed-constexpr
    -Xcompiler=-Wall,-Wextra,-Wshadow,-ffp-contract=off
    $<$<BOOL:${TALUS_WARNINGS_AS_ERRORS}>:-Werror=all-warnings>)
endfunction()
