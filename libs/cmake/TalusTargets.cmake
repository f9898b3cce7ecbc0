# What every target of the project shares.

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "" FORCE)
endif()

set(CMAKE_RUNTIME_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/bin")
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib")
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY "${PROJECT_BINARY_DIR}/lib")

# Sources of a target are compiled several together, so that the headers of libraries are read once for all of them: a
# whole build takes half the processor time, one after a change of one source more. Sources whose local names others of
# the target have, too, stay apart.
option(TALUS_TOGETHER "Compile the sources of libraries, commands and tests several together" OFF)
function(talus_compile_together target)
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${TALUS_TOGETHER} UNITY_BUILD_BATCH_SIZE 20)
endfunction()
function(talus_compile_apart)
  set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
endfunction()

# Language, warnings and the one flag that everything rests on: no contraction of a*b+c into one rounding, so that
# the same frames give the same bits with any compiler and on any device.
function(talus_target_defaults target)
  target_compile_features(${target} PUBLIC cxx_std_17)
  set_target_properties(${target} PROPERTIES CXX_STANDARD 17 CXX_EXTENSIONS OFF POSITION_INDEPENDENT_CODE ON)
  target_compile_options(${target} PRIVATE
    $<$<COMPILE_LANGUAGE:CXX>:-Wall -Wextra -Wpedantic -Wshadow -ffp-contract=off>
    $<$<AND:$<COMPILE_LANGUAGE:CXX>,$<BOOL:${TALUS_WARNINGS_AS_ERRORS}>>:-Werror>)
endfunction()

# talus_add_library(NAME SOURCES...): static library talus_NAME, alias talus::NAME, headers under include/. Installed, it is
# component NAME of the package, with an export set of its own.
function(talus_add_library name)
  add_library(talus_${name} STATIC ${ARGN})
  add_library(talus::${name} ALIAS talus_${name})
  talus_target_defaults(talus_${name})
  talus_compile_together(talus_${name})
  set_target_properties(talus_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(talus_${name}
    PUBLIC $<BUILD_INTERFACE:${CMAKE_CURRENT_SOURCE_DIR}/include> $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
  install(TARGETS talus_${name} EXPORT talusTargets_${name} ARCHIVE COMPONENT dev)
  install(EXPORT talusTargets_${name} NAMESPACE talus:: DESTINATION ${CMAKE_INSTALL_LIBDIR}/cmake/talus COMPONENT dev)
  install(DIRECTORY include/ DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT dev)
  set_property(GLOBAL APPEND PROPERTY TALUS_COMPONENTS ${name})
endfunction()

# talus_vector_loops(SOURCES...): so that loops become vector code, neither errno nor floating-point exceptions are looked
# at, choices stay choices instead of becoming branches, and loops stay whole: checks and calls of their parts cost more.
# Aligned, so that loops do not get slower when code before them changes. No bit depends on it.
function(talus_vector_loops)
  if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set(options -O3 -fno-math-errno -fno-trapping-math
      -fno-thread-jumps -fno-tree-sink -fno-tree-pre -fno-split-paths -fno-tree-dominator-opts -fno-tree-loop-distribution -fno-tree-loop-distribute-patterns
      -falign-loops=32 -falign-functions=64)
    if(CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
      list(APPEND options -mtune=skylake)
    endif()
  else()
    set(options -fno-math-errno -fno-trapping-math -Wno-pass-failed)  # which loops clang leaves as they are
    if(TALUS_SANITIZER)  # a fifth less time for most of what is tested, and no more to build
      list(APPEND options -O2 -fno-sanitize=fuzzer-no-link)
    endif()
  endif()
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS "${options}")
endfunction()

# talus_reads_options(SOURCES...), talus_only_reads_options(TARGET): these run once, in no time, and take three times as
# long to build for speed.
function(talus_reads_options)
  set_source_files_properties(${ARGN} PROPERTIES COMPILE_OPTIONS -O0)
endfunction()
function(talus_only_reads_options target)
  target_compile_options(${target} PRIVATE -O0)
endfunction()

set(TALUS_APP_COMPONENT commands)  # the package that commands are in, see TalusPackages.cmake
find_program(TALUS_HELP2MAN help2man)

# What `whatis` says of each command of the package.
set(whatis_talus-batch "map a folder of logs on all cores or on Slurm")
set(whatis_talus-calibrate "find mounting, clock and noise of a LiDAR from the log of a drive")
set(whatis_talus-compare "judge terrain maps against truth and against each other")
set(whatis_talus-export "write a map of terrain in formats of other programs, or as a page")
set(whatis_talus-import "make a rawlog of scan files and ROS 2 bags")
set(whatis_talus-live "map the terrain around a robot with ROS 2 while it drives")
set(whatis_talus-map "map the terrain of a drive and where a robot can drive there")
set(whatis_talus-merge "make one terrain map of several, or tell what changed")
set(whatis_talus-nav "drive a simulated robot to a goal by its terrain map")
set(whatis_talus-replay "publish a recorded drive on the network of ROS 2")
set(whatis_talus-sim "simulate the LiDAR of a robot that drives through a world")

# talus_add_manual(NAME PROGRAM): a page of section 1 for a command of the package, where Debian's help2man is there; and
# the completion of its options.
function(talus_add_manual name program)
  if(TALUS_APP_COMPONENT MATCHES "^(commands|live)$")
    install(FILES "${PROJECT_SOURCE_DIR}/apps/common/completion.bash" RENAME ${name}
      DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions COMPONENT ${TALUS_APP_COMPONENT})
  endif()
  if(NOT TALUS_HELP2MAN OR CMAKE_CROSSCOMPILING OR TALUS_SANITIZER OR NOT TALUS_APP_COMPONENT MATCHES "^(commands|live)$")
    return()
  endif()
  set(page "${PROJECT_BINARY_DIR}/man/${name}.1.gz")
  file(MAKE_DIRECTORY "${PROJECT_BINARY_DIR}/man")
  add_custom_command(OUTPUT "${page}" DEPENDS ${program} VERBATIM
    COMMAND "${TALUS_HELP2MAN}" --no-info --version-string=${PROJECT_VERSION} "--name=${whatis_${name}}"
      "--output=${PROJECT_BINARY_DIR}/man/${name}.1" "${program}"
    COMMAND gzip -9nf "${PROJECT_BINARY_DIR}/man/${name}.1")
  add_custom_target(${name}.1 ALL DEPENDS "${page}")
  install(FILES "${page}" DESTINATION ${CMAKE_INSTALL_MANDIR}/man1 COMPONENT ${TALUS_APP_COMPONENT} OPTIONAL)
endfunction()

# talus_add_app(NAME SOURCES...): a command; options.cpp, where it has one, reads its command line. Its manual is what
# --help says.
function(talus_add_app name)
  add_executable(${name} ${ARGN})
  talus_target_defaults(${name})
  talus_compile_together(${name})
  talus_reads_options(options.cpp)
  target_compile_definitions(${name} PRIVATE TALUS_VERSION="${PROJECT_VERSION}")
  if(TALUS_APP_COMPONENT STREQUAL "bench")  # what measures this build
    return()
  endif()
  install(TARGETS ${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${TALUS_APP_COMPONENT})
  talus_add_manual(${name} $<TARGET_FILE:${name}>)
endfunction()
