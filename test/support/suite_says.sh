#!/bin/sh
# suite.sh, tried with a program that says what GoogleTest says: suite_says.sh FOLDER
set -eu
run="$(dirname "$0")/suite.sh" folder=$1
rm -rf "$folder"
mkdir -p "$folder"
cat >"$folder/program" <<'END'
#!/bin/sh
case $1 in *:*) ;; *) echo "alone, with $1"; exit 4 ;; esac
printf '[ RUN      ] S.good\nhalf a line[       OK ] S.good (0 ms)\n'
printf '[ RUN      ] Of/S.skips/0\nwhy\n[  SKIPPED ] Of/S.skips/0 (0 ms)\n'
printf '[ RUN      ] S.bad\n1 is not 2\n[  FAILED  ] S.bad, where GetParam() = 3 (0 ms)\nbetween\n'
printf '[ RUN      ] S.dies\nlast words\n'
exit 3
END
chmod +x "$folder/program"

# says CODE TEXT ARGUMENTS...: how suite.sh must end, and what it must say with these.
says() {
  code=0 wanted=$1 text=$2
  shift 2
  said=$("$run" "$@") || code=$?
  case $said in *"$text"*) [ $code -ne "$wanted" ] || return 0 ;; esac
  printf '%s\n' "suite.sh $*" "ended with $code instead of $wanted, and said this instead of '$text':" "$said"
  exit 1
}
says 3 between all "$folder/S" "$folder/program" S.good:S.bad
says 0 "half a line[       OK ]" case "$folder/S" "$folder/program" S.good S.good
says 4 "alone, with --gtest_filter=S.good" case "$folder/S" "$folder/program" S.good S.good  # asked for again
says 0 "[  SKIPPED ]" case "$folder/S" "$folder/program" Of/S.skips/0 Of+S.skips+0
says 1 "1 is not 2" case "$folder/S" "$folder/program" S.bad S.bad
says 1 "last words
The process ended here, with exit code 3." case "$folder/S" "$folder/program" S.dies S.dies
says 4 "alone" case "$folder/S" "$folder/program" S.after S.after  # a case that did not get its turn
