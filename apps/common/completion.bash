# Completion of the commands of talus: options as --help names them, parameters after -s and --set, else files.
_talus()
{
  local command=$1 word=$2 before=$3 found
  COMPREPLY=()
  case $before in
    -s | --set) found=$("$command" --parameters 2>/dev/null | grep -oE '^ *[a-z][a-z0-9_]* ' | sed 's/ *$/=/') ;;
    *)
      [[ $word == -* ]] || return 0
      found=$("$command" --help 2>/dev/null | grep -oE '^ +(-[a-zA-Z], ?)?--[a-z][a-z0-9-]*' | grep -oE -- '--.*') ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$found" -- "$word")
  [[ ${COMPREPLY[0]-} != *= ]] || compopt -o nospace 2>/dev/null
  return 0
}
complete -o bashdefault -o default -F _talus \
  talus-batch talus-calibrate talus-compare talus-import talus-map talus-merge talus-nav talus-sim
