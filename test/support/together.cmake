# Writes one source that includes several tests, each in a namespace of its own, so that they may use the same names.
# All headers come before, at global scope; where the tests include them again, nothing follows.
#   cmake -D "SOURCES=a.cpp;b.cpp" -D OUTPUT= -P together.cmake
cmake_minimum_required(VERSION 3.22)
set(headers "")
set(by_macro "")  # these need others before them
set(tests "")
foreach(source IN LISTS SOURCES)
  file(STRINGS "${source}" lines REGEX "^ *#include ")
  foreach(line IN LISTS lines)
    if(line MATCHES "\\(")
      list(APPEND by_macro "${line}")
    else()
      list(APPEND headers "${line}")
    endif()
  endforeach()
  get_filename_component(name "${source}" NAME_WE)
  string(APPEND tests "namespace\n{\nnamespace of_${name}\n{\n#include \"${source}\"\n}\n}\n")
endforeach()
list(REMOVE_DUPLICATES headers)
list(REMOVE_DUPLICATES by_macro)
list(JOIN headers "\n" headers)
list(JOIN by_macro "\n" by_macro)
file(WRITE "${OUTPUT}" "${headers}\n${by_macro}\n${tests}")
