# Completion of handgraft, handgraft-server and handgraft-bridge in bash: commands and options come from
# the program's own --help, so that they are written down once.
# shellcheck disable=SC2207  # names of commands and options hold no spaces
_handgraft() {
  local word=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]}
  local -a said=("${COMP_WORDS[0]}")
  local i
  # The words before this one that name commands.
  for ((i = 1; i < COMP_CWORD; ++i)); do
    [[ ${COMP_WORDS[i]} == [a-z]* ]] || break
    said+=("${COMP_WORDS[i]}")
  done
  local help
  help=$("${said[@]}" --help 2>/dev/null) || help=$("${COMP_WORDS[0]}" "${COMP_WORDS[1]}" --help 2>/dev/null)
  case $previous in
    --interface)
      COMPREPLY=($(compgen -W "$(ls /sys/class/net 2>/dev/null)" -- "$word"))
      return
      ;;
  esac
  if [[ $word == -* ]]; then
    COMPREPLY=($(compgen -W "$(grep -oE -- '--[a-z][a-z0-9-]*' <<<"$help" | sort -u)" -- "$word"))
    return
  fi
  local commands
  commands=$(sed -n '/^Subcommands:/,$ s/^  \([a-z][a-z-]*\) .*/\1/p' <<<"$help")
  COMPREPLY=($(compgen -W "$commands" -- "$word") $(compgen -f -- "$word"))
}
complete -o filenames -F _handgraft handgraft handgraft-server handgraft-bridge
