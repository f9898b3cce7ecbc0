# Writes the commit that is built into a header, where it is another one. Empty where there is no git or no repository.
#   cmake -DSOURCE=DIR -DHEADER=FILE -P commit.cmake
find_program(git git)
set(commit)
if(git AND EXISTS "${SOURCE}/.git")
  execute_process(COMMAND "${git}" -C "${SOURCE}" rev-parse --short=10 HEAD
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
endif()
file(CONFIGURE OUTPUT "${HEADER}" CONTENT "#define TALUS_COMMIT \"${commit}\"\n")
