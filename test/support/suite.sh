#!/bin/sh
# The cases of a suite of GoogleTest share a process, as loading the libraries takes longer than most of them do; for
# ctest each is a test by itself all the same.
#   suite.sh all FOLDER PROGRAM FILTER      runs them, and keeps what each says
#   suite.sh case FOLDER PROGRAM CASE FILE  tells that, or runs the case by itself: where only it was asked for, is asked
#                                           for again, or did not get its turn as a case before it ended the process
set -eu
how=$1 folder=$2 program=$3
filter=$4 file=${5-}
read -r stat <"/proc/$PPID/stat"
set -- ${stat##*) }
run=$PPID.${20}  # this run of ctest and no other: its process and when that began

if [ "$how" = case ]; then
  for code in 0 1; do
    said=$folder/$run/$file.$code
    if [ -s "$said" ]; then  # told and emptied by the shell: starting cat and rm would take as long as a case
      while IFS= read -r line; do printf '%s\n' "$line"; done <"$said"
      : >"$said"
      exit $code
    fi
  done
  exec "$program" "--gtest_filter=$filter"
fi

rm -rf "$folder"
mkdir -p "$folder/$run"
code=0
"$program" "--gtest_filter=$filter" >"$folder/all.log" 2>&1 || code=$?
# What belongs to no case is said here: the list of what failed, and what is told when the process ends.
awk -v to="$folder/$run/" -v code=$code '
  function keep(result) {
    gsub("/", "+", name)
    printf "%s", said >(to name "." result)
    close(to name "." result)
    name = said = ""
  }
  function ends(result) { at = index($0, result " " name); return at && substr($0, at + length(result " " name)) ~ /^[ ,]/ }
  at = index($0, "[ RUN      ] ") { name = substr($0, at + 13) }
  name == "" { print; next }
  { said = said $0 "\n" }
  ends("[       OK ]") || ends("[  SKIPPED ]") { keep(0); next }
  ends("[  FAILED  ]") { keep(1) }
  END {
    if (code && name == "") print "The process ended with exit code " code "."
    if (name == "") exit
    said = said "The process ended here, with exit code " code ".\n"
    keep(1)
  }' "$folder/all.log"
exit $code
