# Writes the script `kinegraph` that starts the commands, the manual pages and the
# shells' completions, from the commands' --help and their list by task, TASKS.
#   cmake -D PROGRAMS=... -D OUT=FOLDER -D VERSION=... -D TASKS=apps/commands.txt
#     -P make_pages.cmake
file(READ ${TASKS} tasks)
string(REGEX REPLACE "^(#[^\n]*\n)+" "" tasks "${tasks}")
separate_arguments(PROGRAMS)
file(MAKE_DIRECTORY ${OUT})
set(bash_cases "")
set(names "")

foreach(program ${PROGRAMS})
  get_filename_component(name ${program} NAME)
  string(REGEX REPLACE "^kinegraph-" "" command ${name})
  execute_process(COMMAND ${program} --help OUTPUT_VARIABLE help
    RESULT_VARIABLE result)
  if(NOT result EQUAL 0)
    message(FATAL_ERROR "${name} --help ended with ${result}")
  endif()
  string(REGEX MATCH "^[^:]*: ([^\n]*)" first_line "${help}")
  set(summary "${CMAKE_MATCH_1}")
  string(REGEX MATCH "\n  ${command} +([^\n]*)" listed "${tasks}")
  if(NOT CMAKE_MATCH_1 STREQUAL summary)
    message(FATAL_ERROR
      "${command}: apps/commands.txt has '${CMAKE_MATCH_1}', its --help '${summary}'")
  endif()
  # roff interprets lines that begin with a dot or an apostrophe as requests, and
  # gives backslashes and hyphens a special meaning.
  string(REPLACE "\\" "\\e" body "${help}")
  string(REPLACE "-" "\\-" body "${body}")
  string(REGEX REPLACE "\n([.'])" "\n\\\\&\\1" body "${body}")
  string(TOUPPER ${name} title)
  file(WRITE ${OUT}/${name}.1 ".TH ${title} 1 \"\" \"kinegraph ${VERSION}\"
.SH NAME
${name} \\- ${summary}
.SH DESCRIPTION
.nf
${body}
.fi
.SH EXIT STATUS
0: success. 2: invalid usage or input, with one line of explanation on standard
error. 1: anything else.
")
  string(REGEX MATCHALL "\n  --[a-z_]+" flags "${help}")
  string(REGEX REPLACE "\n  " "" flags "${flags}")
  # The help must contain two examples, with existing flags.
  string(REGEX MATCHALL "\n  kinegraph ${command}[^\n]*" examples "${help}")
  string(REGEX MATCHALL "--[a-z_]+" used "${examples}")
  list(LENGTH examples count)
  list(REMOVE_ITEM used ${flags})
  if(NOT count EQUAL 2 OR used)
    message(FATAL_ERROR
      "${name} --help: ${count} examples, expected two; unknown flags in them: ${used}")
  endif()
  string(REPLACE ";" " " flags "${flags}")
  string(APPEND bash_cases "    ${command}) flags='${flags}' ;;\n")
  list(APPEND names ${command})
endforeach()

list(TRANSFORM names PREPEND kinegraph- OUTPUT_VARIABLE programs)
list(JOIN programs " " programs)
list(JOIN names " " names)
configure_file(${CMAKE_CURRENT_LIST_DIR}/kinegraph.sh.in ${OUT}/kinegraph @ONLY
  FILE_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE
    WORLD_READ WORLD_EXECUTE)
file(WRITE ${OUT}/kinegraph.bash "# Completion of kinegraph's commands, flags and files for bash and zsh.
_kinegraph_flags() {
  local flags=''
  case \$1 in
${bash_cases}  esac
  echo \"\$flags\"
}
_kinegraph() {
  local word=\${COMP_WORDS[COMP_CWORD]} command=\${COMP_WORDS[0]##*/kinegraph-}
  command=\${command#kinegraph-}
  if [[ \${COMP_WORDS[0]##*/} == kinegraph ]]; then
    if ((COMP_CWORD == 1)); then
      COMPREPLY=(\$(compgen -W '${names}' -- \"\$word\"))
      return
    fi
    command=\${COMP_WORDS[1]}
  fi
  if [[ \$word == --* ]]; then
    COMPREPLY=(\$(compgen -W \"\$(_kinegraph_flags \"\$command\")\" -- \"\$word\"))
  else
    COMPREPLY=(\$(compgen -f -- \"\$word\"))
  fi
}
complete -o default -F _kinegraph kinegraph ${programs}
")
file(WRITE ${OUT}/_kinegraph "#compdef kinegraph
autoload -U +X bashcompinit && bashcompinit
source /usr/share/bash-completion/completions/kinegraph
")
file(WRITE ${OUT}/kinegraph.1 ".TH KINEGRAPH 1 \"\" \"kinegraph ${VERSION}\"
.SH NAME
kinegraph \\- 3D motion of people from the 2D poses that calibrated cameras see
.SH SYNOPSIS
.B kinegraph
COMMAND [flags]
.SH COMMANDS
.nf
${tasks}
.fi
.PP
Each has a page of its own: man kinegraph\\-COMMAND.
")
